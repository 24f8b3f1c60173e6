# SPDX-License-Identifier: Apache-2.0
"""The package as a whole: import, types, signatures, bars."""

import inspect
import io
import json
import os
import pathlib
import pickle
import subprocess
import sys

import mcvisi as mv
import pytest

PACKAGE = pathlib.Path(mv.__file__).parent


def test_import_is_quick():
    """Below 100 ms of processor time, and nothing that takes long is imported."""
    script = (
        "import sys, time; begin = time.process_time(); import mcvisi\n"
        "print(time.process_time() - begin)\n"
        "late = {'numpy', 'cffi', 'pandas', 'xarray', 'IPython', 'pyopencl', 'asyncio'}\n"
        "print(sorted(late & set(sys.modules)))\n"
    )
    times = []
    for _ in range(5):
        out = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stdout
        words = out.decode().splitlines()
        assert words[1] == "[]"
        times.append(float(words[0]))
    assert min(times) < 0.1


def test_the_version_is_the_library_s():
    from mcvisi.library import ffi, library

    assert ffi.string(library().mcv_version()).decode() == mv.__version__


def test_signatures_follow_from_the_option_list():
    from mcvisi.library import ffi, json_of

    for function, verb, renamed in (
        (mv.Rig.render, b"render", {}),
        (mv.Image.camera, b"camera", {}),
        (mv.Image.measure, b"measure", {"edge": "edges", "region": "regions", "line": "lines"}),
        (mv.Rig.sweep, b"sweep", {"metric": "metrics", "in": "in_", "tie": "ties"}),
    ):
        parameters = inspect.signature(function).parameters
        text = inspect.getdoc(function)
        options = json_of("mcv_options_schema", verb)["properties"]
        for name in ("spp", "seed", "bits", "edge", "metric", "in", "noise"):
            if name in options and renamed.get(name, name) in parameters:
                assert options[name]["description"].split(";")[0][:30] in " ".join(text.split())
        for name in renamed:
            assert renamed[name] in parameters


def test_an_unknown_argument_is_told_of_the_class_that_users_know():
    with pytest.raises(
        TypeError, match=r"^Rig\.render\(\) got an unexpected keyword argument 'ssp'"
    ):
        mv.Rig({"asset": {"version": "2.0"}}).render(ssp=4)
    with pytest.raises(TypeError, match=r"^Image\.camera\(\) got"):
        mv.Image([[1.0]]).camera(exposure=1)


def test_types_are_strict(tmp_path):
    pytest.importorskip("mypy")
    (tmp_path / "user.py").write_text(
        "import pathlib\n"
        "import mcvisi as mv\n"
        "rig = mv.new('telecentric', 'part.stl', unit='mm', resolution=(96, 64))\n"
        "image = rig.render(spp=16, sampler='sobol', progress=lambda state: state.fraction < 0.5)\n"
        "value = image.measure(edges={'left': (1, 2, 3, 4)})['left'].length\n"
        "image = rig.render(split=False, checkpoint=pathlib.Path('a.film'), sensor=0)\n"
        "rig.add_defect('dent', node='part', triangle=1, size=2e-4)\n"
        "rows = [row.message for row in rig.sweep({'a/b/c': [1, 2]}, metrics={'m': 'x'})]\n"
        "reveal_type(image.error)\n"
    )
    (tmp_path / "wrong.py").write_text(
        "import mcvisi as mv\nmv.load('a').render(sampler='halton')\nmv.load('a').render(ssp=4)\n"
    )
    environment = {**os.environ, "MYPYPATH": str(PACKAGE.parent)}

    def mypy(*arguments):
        command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
        return subprocess.run(
            [*command, *map(str, arguments)], env=environment, capture_output=True, text=True
        )

    # The package is checked with it: errors of its files would stand there.
    right = mypy(tmp_path / "user.py", *sorted(PACKAGE.glob("[!_]*.py")), PACKAGE / "_verbs.py")
    assert "error:" not in right.stdout, right.stdout
    assert "ndarray" in right.stdout
    assert mypy(tmp_path / "wrong.py").stdout.count("error:") == 2


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_bar_in_a_terminal(rig, monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    rig.render(time=2, resolution=(192, 128))
    assert "%" in terminal.getvalue() and terminal.getvalue().endswith("\r\x1b[K")


def test_no_bar_in_a_file(rig, monkeypatch):
    file = io.StringIO()
    monkeypatch.setattr(sys, "stderr", file)
    rig.render(spp=16)
    assert file.getvalue() == ""


def test_a_bar_in_a_notebook():
    from mcvisi.bar import NotebookBar
    from mcvisi.work import Job

    class Told:
        fraction, seconds, error = 0.5, 1.0, float("inf")

    shown = []

    class Handle:
        def update(self, data, raw):
            shown.append(data)

    def display(data, raw, display_id):
        shown.append(data)
        return Handle()

    bar = NotebookBar(display)
    bar(mv.Progress(Job(lambda job: None), Told))
    bar(mv.Progress(Job(lambda job: None), Told))
    bar.close()
    assert len(shown) == 3 and "50 %" in shown[0]["text/plain"]


@pytest.mark.parametrize(
    "program, python",
    [
        ("give --exposure-time or --expose-to.", "give exposure_time or expose_to."),
        ("--metric is missing, --in F, --with A=B", "metrics is missing, in_ F, with_ A=B"),
        ("run `mcvisi render --spp 4`, then --edge", "run `mcvisi render --spp 4`, then edges"),
        ("a--b.exr: no -- here", "a--b.exr: no -- here"),
    ],
)
def test_sentences_name_options_as_python_does(program, python):
    from mcvisi.library import in_python

    assert in_python(program) == python


def test_what_holds_a_device_is_not_pickled(rig):
    sweep = rig.sweep({"sensors/camera/fNumber": [4, 8]}, metrics=["mean"])
    for thing in (mv.Session(), sweep):
        with pytest.raises(mv.UsageError, match="pickled"):
            pickle.dumps(thing)


def test_errors():
    assert issubclass(mv.BadInput, ValueError) and issubclass(mv.DeviceError, RuntimeError)
    assert issubclass(mv.UsageError, TypeError) and issubclass(mv.PathError, KeyError)
    assert all(issubclass(e, mv.Error) for e in (mv.BadInput, mv.DeviceError, mv.UsageError))
    assert [e.code for e in (mv.Error, mv.UsageError, mv.BadInput, mv.DeviceError)] == [1, 2, 3, 4]


def test_devices():
    for device in mv.devices():
        assert {"number", "name", "type"} <= set(device)
    assert json.dumps(mv.devices())
