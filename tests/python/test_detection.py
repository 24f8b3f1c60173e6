# SPDX-License-Identifier: Apache-2.0
"""The probability of detection."""

import mcvisi as mv
import numpy as np
import pytest


def line():
    sizes = np.repeat(np.arange(1.0, 21), 2)
    return sizes, sizes + np.tile([-2, 2], 20)


def test_values():
    sizes, signals = line()
    report = mv.pod_values(
        sizes, signals, threshold="8", size_scale="linear", signal_scale="linear", size_unit="none"
    )
    # By the noncentral t of SciPy.
    assert report["a90_bound"] == pytest.approx(11.4964950885, rel=1e-9)
    assert report["answer"].startswith("A defect of 11.5 is found in nine of ten cases")
    assert report["defects"] == 40 and len(report["curve"]) > 10


def test_table_gives_the_same(tmp_path):
    sizes, signals = line()
    rows = ["%g,%g,%d" % (a, y, y > 8) for a, y in zip(sizes, signals)]
    (tmp_path / "t.csv").write_text("\n".join(["depth,peak,found", *rows]))
    table = mv.pod_table(tmp_path / "t.csv", size="depth", hit="found")
    values = mv.pod_values(sizes, signals > 8, hits=True)
    assert table == values


def test_refused(tmp_path):
    sizes, signals = line()
    with pytest.raises(mv.UsageError, match="threshold"):
        mv.pod_values(sizes, signals)
    with pytest.raises(mv.UsageError, match="as sizes"):
        mv.pod_values(sizes, signals[1:], threshold="8")
    with pytest.raises(mv.UsageError, match="one dimension"):
        mv.pod_values([sizes], signals, threshold="8")
    with pytest.raises(mv.UsageError, match="array of numbers"):
        mv.pod_values("no", signals, threshold="8")
    with pytest.raises(mv.BadInput, match="none.csv"):
        mv.pod_table(tmp_path / "none.csv", hit="x")


# The grey value of a pixel before the backlight: the "size" is the radiance. At 1 it is 0.0491 W/m^2,
# and so some 1000 electrons.
STUDY = {"size": "radiance", "signal": "grey", "size_unit": "none"}
SCALES = {"size_scale": "linear", "signal_scale": "linear"}
CAMERA = {"electrons_per_unit": 1000 / 0.0491, "full_well": 4095, "bits": 12, "read_noise": 100}


def study_of(rig, study, **options):
    return rig.pod(
        {"emitters/light/radiance": mv.linear(0.4, 1.6, 24)},
        study,
        metrics={"grey": "mid.mean"},
        regions={"mid": (4, 4, 1, 1)},
        spp=4,
        progress=False,
        **{**CAMERA, **options},
    )


def test_an_experiment(rig, tmp_path):
    told = {**STUDY, **SCALES, "threshold": 1000}
    study = study_of(rig, told, output=tmp_path / "t.csv")
    answer = study.answer
    assert len(study) == 24 and all(row.message is None for row in study)
    # The grey value is 1000 x with a noise of 105: known to 105/√24 where it crosses; four of these.
    assert study.report["a50"]["value"] == pytest.approx(1, abs=4 * 0.105 / 24**0.5)
    # The same of the table that the sweep has written.
    table = mv.pod_table(tmp_path / "t.csv", **{**told, "threshold": "1000"})
    assert answer == table["answer"] and study.report["curve"] == table["curve"]
    assert "srcdoc" in study._repr_html_() and (tmp_path / "t-pod.html").exists()


def short_study(rig, count):
    return rig.pod(
        {"emitters/light/radiance": mv.linear(0.4, 1.6, count)},
        {**STUDY, **SCALES, "threshold": 1000},
        metrics={"grey": "mid.mean"},
        regions={"mid": (4, 4, 1, 1)},
        spp=4,
        progress=False,
        **CAMERA,
    )


def test_too_few_defects_are_told_again(rig):
    study = short_study(rig, 4)
    with pytest.raises(mv.BadInput, match="at least 10 are needed"):
        list(study)
    assert len(study.rows) == 4
    with pytest.raises(mv.BadInput, match="at least 10 are needed"):
        study.answer


def test_an_experiment_that_was_left_has_no_answer(rig):
    """Nothing is raised where the loop is left; it would be printed, as in every generator."""
    study = short_study(rig, 24)
    for row in study:
        break
    assert 1 <= len(study.rows) < 24
    with pytest.raises(mv.Error, match="no answer|at least 10"):
        study.answer


def test_an_experiment_refused(rig):
    with pytest.raises(mv.UsageError, match="study: must be a dictionary"):
        study_of(rig, "size=radiance")
    with pytest.raises(mv.UsageError, match="threshold"):
        list(study_of(rig, STUDY))
    with pytest.raises(mv.UsageError, match="sgnal"):
        list(study_of(rig, {"sgnal": "grey"}))
    with pytest.raises(mv.UsageError, match="threshold: must be a finite number"):
        study_of(rig, {**STUDY, "threshold": float("nan")})
