# SPDX-License-Identifier: Apache-2.0
"""Rigs: paths, values, copies, files."""

import copy
import json
import pathlib
import pickle

import mcvisi as mv
import numpy as np
import pytest


def test_values_by_path(rig):
    assert rig["sensors/camera/type"] == "telecentric"
    rig["sensors/camera/fNumber"] = 8
    assert rig["sensors/camera/fNumber"] == 8
    rig["nodes/light/distance"] = "80mm"
    assert rig["nodes/light/distance"] == "80mm"
    assert "nodes/light/distance" in rig
    assert "nodes/light/nothing" not in rig


@pytest.mark.parametrize(
    "value, written",
    [
        (np.float32(0.5), 0.5),
        (np.int64(3), 3),
        (np.array([64, 48]), [64, 48]),
        ((64, 48), [64, 48]),
        ("8", "8"),
        ("true", "true"),
        ("größer", "größer"),
        (True, True),
    ],
)
def test_values_of_numpy_and_texts_stay_what_they_are(rig, value, written):
    rig["sensors/camera/extras"] = value
    assert rig["sensors/camera/extras"] == written
    assert type(rig["sensors/camera/extras"]) is type(written)


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_numbers_are_finite(rig, value):
    with pytest.raises(mv.BadInput, match="finite"):
        rig["sensors/camera/fNumber"] = value


@pytest.mark.parametrize("value", [object(), {1, 2}, b"bytes"])
def test_other_objects_are_refused(rig, value):
    with pytest.raises(mv.UsageError, match="numbers, texts"):
        rig["sensors/camera/fNumber"] = value


@pytest.mark.parametrize("path", ["sensors/none/fNumber", "nothing", "sensors//fNumber", "a\0b"])
def test_a_path_that_does_not_exist_is_a_key_error_with_a_sentence(rig, path):
    with pytest.raises(KeyError) as failure:
        rig[path]
    assert isinstance(failure.value, mv.BadInput) and failure.value.code == 3
    assert len(str(failure.value)) > 20 and not str(failure.value).startswith("'")
    with pytest.raises(KeyError):
        rig[path] = 1


@pytest.mark.parametrize("path", [None, 7, b"sensors", ("a", "b")])
def test_a_path_is_a_text(rig, path):
    with pytest.raises(mv.UsageError):
        rig[path]


def test_attributes(rig):
    assert rig.sensors.camera.fNumber == rig["sensors/camera/fNumber"]
    rig.sensors.camera.fNumber = 11
    assert rig["sensors/camera/fNumber"] == 11
    assert rig.sensors["camera"]["fNumber"] == 11
    with pytest.raises(AttributeError, match="sensors"):
        rig.sensor
    with pytest.raises(AttributeError):
        rig.sensors.none


@pytest.mark.parametrize("name", ["sensor", "sensors", "fNumber"])
def test_an_attribute_that_would_change_nothing_is_refused(rig, name):
    with pytest.raises(AttributeError, match="by its path"):
        setattr(rig, name, 8)


def test_tab_completes_paths(rig):
    assert "sensors/camera/fNumber" in rig._ipython_key_completions_()
    assert {"sensors", "emitters", "nodes"} <= set(dir(rig))
    assert "camera" in dir(rig.sensors)
    assert "fNumber" in dir(rig.sensors.camera)
    # Each path that is offered is there.
    for path in rig.paths():
        rig[path]


def test_completion_in_ipython(rig):
    pytest.importorskip("IPython")
    pytest.importorskip("jedi")
    from IPython.core.completer import provisionalcompleter
    from IPython.core.interactiveshell import InteractiveShell

    shell = InteractiveShell.instance()
    shell.user_ns["rig"] = rig
    for text, completed in (
        ("rig.sen", "sensors"),
        ("rig.sensors.c", "camera"),
        ("rig.sensors.camera.fN", "fNumber"),
        ('rig["sensors/camera/fN', "sensors/camera/fNumber"),
    ):
        with provisionalcompleter():
            found = [item.text for item in shell.Completer.completions(text, len(text))]
        assert completed in found


def test_repr_names_what_there_is(rig):
    assert "camera" in repr(rig) and "light" in repr(rig)
    assert "fNumber" in repr(rig.sensors.camera)
    assert "<table>" in rig._repr_html_()


def test_html_is_escaped(rig):
    rig["sensors/camera/extras"] = "</table><script>alert(1)</script>"
    assert "<script>" not in rig._repr_html_()


@pytest.mark.parametrize(
    "clone", [copy.copy, copy.deepcopy, lambda r: pickle.loads(pickle.dumps(r))]
)
def test_copies_are_independent(rig, clone):
    other = clone(rig)
    other["sensors/camera/fNumber"] = 16
    assert rig["sensors/camera/fNumber"] != 16
    assert other["nodes"] == rig["nodes"]
    # Its part is found, too.
    assert other.check().report["triangles"] == rig.check().report["triangles"]


def test_pickle_of_a_binary_file():
    """A .glb holds its meshes itself."""
    rig = mv.load(pathlib.Path(__file__).resolve().parents[2] / "scenes" / "report-dent.glb")
    rig["emitters/panel/radiance"] = 12
    again = pickle.loads(pickle.dumps(rig))
    assert again["emitters/panel/radiance"] == 12
    assert again.check().report["triangles"] == rig.check().report["triangles"] > 0


def test_save_and_load(rig, folder):
    path = folder / "ein Gerät.gltf"
    rig["sensors/camera/fNumber"] = 22
    rig.save(path)
    assert json.loads(path.read_text(encoding="utf-8"))["asset"]["version"] == "2.0"
    again = mv.load(path)
    assert again["sensors/camera/fNumber"] == 22
    assert again.path == str(path) and again.folder == str(folder)
    again["sensors/camera/fNumber"] = 5.6
    again.save()
    assert mv.load(str(path))["sensors/camera/fNumber"] == 5.6


def test_save_elsewhere_is_refused(rig, tmp_path):
    with pytest.raises(mv.UsageError):
        rig.save(tmp_path / "other.gltf")
    assert not list(tmp_path.iterdir())


def test_bad_files(tmp_path):
    with pytest.raises(mv.BadInput, match="none.gltf"):
        mv.load(tmp_path / "none.gltf")
    (tmp_path / "broken.gltf").write_text("{")
    with pytest.raises(mv.BadInput, match="broken.gltf"):
        mv.load(tmp_path / "broken.gltf")
    with pytest.raises(mv.Error):
        mv.new("telecentric", tmp_path / "none.stl", unit="mm")
    for wrong in (None, 7, ["a"], "a\0b"):
        with pytest.raises(mv.UsageError):
            mv.load(wrong)


def test_new_says_what_it_chose(rig):
    assert rig.path is None
    assert rig.report["field_of_view"][0] > 0.0636


def test_a_document(folder):
    rig = mv.new("telecentric", folder / "bracket.stl", unit="mm")
    assert mv.Rig(rig[""], folder=folder)[""] == rig[""]
    with pytest.raises(mv.UsageError):
        mv.Rig({"asset": object()})


def test_closed(rig):
    with rig:
        part = rig.sensors
    for use in (
        lambda: rig["sensors"],
        lambda: rig.check(),
        lambda: rig.render(),
        lambda: rig.save(),
        lambda: rig.copy(),
        lambda: part.camera,
        lambda: pickle.dumps(rig),
    ):
        with pytest.raises(mv.UsageError, match="this rig is closed"):
            use()
    rig.close()
    assert "closed" in repr(rig)
    dir(rig)


def test_findings(rig):
    findings = rig.check()
    assert findings.report["sensors"][0]["name"] == "camera"
    notes = [finding for finding in findings if finding.severity == "note"]
    assert notes and notes[0].path == "sensors/camera" and "grow" in str(notes[0])
    assert not findings.errors
    rig["nodes/light/azimuth"] = "0deg"
    assert any(finding.severity != "note" for finding in rig.check())
    assert "<table>" in rig.check()._repr_html_()


def test_strict_findings(rig):
    """Those of the file alone, by the rules of glTF."""
    assert rig.check(strict=True) == []
    rig["nodes/light/mesh"] = 4
    found = rig.check(strict=True)
    assert [f.path.split("/")[-1] for f in found.errors] == ["mesh"]
    assert found.report["strict"][0]["code"] == "UNRESOLVED_REFERENCE"


def test_trace(rig):
    columns = rig.trace([[0, 0, 0.1, 0, 0, -1], [0.001, 0, 0.1, 0, 0, -1]])
    assert len(columns["ray"]) >= 2
    with pytest.raises(mv.UsageError, match="six numbers"):
        rig.trace([[0, 0, 0]])


def test_camera_models_go_to_other_programs_and_back(rig, tmp_path):
    model = rig.camera_model()
    image = rig.render(spp=4, resolution=(24, 16), progress=False)
    assert rig.camera_model(resolution=(24, 16))["A"] == image.camera_model["A"]
    for name in ("json", "opencv", "halcon"):
        path = tmp_path / name
        text = rig.export_camera(format=name, output=path)
        assert path.read_text() == text
        report = rig.copy().import_camera(path, sensor="again")
        assert report["sensor"] == "again" and report["model"] == "telecentric"
        other = rig.copy()
        other.import_camera(path, sensor="again")
        found = other.camera_model(sensor="again")
        # of doubles, by some ten operations
        np.testing.assert_allclose(found["A"], model["A"], rtol=1e-12, atol=1e-9)
        assert "again" not in str(rig.camera_model())
    with pytest.raises(mv.BadInput, match="ROS has no such model"):
        rig.export_camera(format="ros")
    with pytest.raises(mv.UsageError, match="already"):
        rig.import_camera(path)


def test_pictures_do_not_name_a_file_that_is_another_scene(rig, folder):
    """What was set can be repeated from the file; a defect cannot, until the rig is saved."""
    rig.save(folder / "flawless.gltf")

    def named(rig):
        found = rig.render(spp=4, resolution=(8, 6), device="reference", progress=False).attributes
        return found["mcvisi:scene"].split("/")[-1], found["mcvisi:set"]

    rig["sensors/camera/fNumber"] = 8
    assert named(rig) == ("flawless.gltf", "sensors/camera/fNumber=8")
    rig.add_defect("dent", node="part", at=(0.012, 0.003, 0.006), size=2e-3)
    for changed in (rig, rig.copy()):
        assert named(changed)[0] == "flawless.gltf (changed)"
        assert changed.path == str(folder / "flawless.gltf")
    rig.save(folder / "dented.gltf")
    assert named(rig) == ("dented.gltf", "")


def test_defects_are_put_onto_surfaces(rig):
    node = rig["nodes"][0]["name"]
    added = rig.add_defect("dent", node=node, triangle="0", size="0.1mm", with_=["shape=cosine"])
    assert added["defect"] == "dent-1" and added["size"] == pytest.approx(1e-4)
    assert added["depth"] == pytest.approx(1e-5)  # a tenth
    rig.defects["dent-1"].size = "0.2mm"
    assert rig["defects/dent-1/size"] == "0.2mm"
    with pytest.raises(mv.BadInput, match="off the surface"):
        rig.add_defect("bump", node=node, at="1m,1m,1m", size="0.1mm")
    assert len(rig["defects"]) == 1
