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
