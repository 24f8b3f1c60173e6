# SPDX-License-Identifier: Apache-2.0
"""The wheel: built, installed into an empty environment, and used from there. Slow: it compiles."""

import os
import pathlib
import subprocess
import sys
import venv
import zipfile

import mcvisi
import pytest
from mcvisi import examples

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheels")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", folder, ROOT]
    built = subprocess.run(command, capture_output=True, text=True)
    assert built.returncode == 0, built.stdout[-3000:] + built.stderr[-3000:]
    plain, whole = next(folder.glob("*.whl")), folder / "whole"
    command = [sys.executable, "-B", ROOT / "python" / "repair.py", plain, whole]
    repaired = subprocess.run(command, capture_output=True, text=True)
    assert repaired.returncode == 0, repaired.stdout[-3000:] + repaired.stderr[-3000:]
    return next(whole.glob("*.whl"))


@pytest.fixture(scope="module")
def python(wheel, tmp_path_factory):
    """An environment in a path with spaces, with numpy and cffi of this one: no network."""
    folder = tmp_path_factory.mktemp("an environment with spaces")
    venv.create(folder, with_pip=True)
    install = [folder / "bin" / "pip", "install", "--quiet", "--no-deps", "--no-index", wheel]
    subprocess.run(install, check=True)
    import cffi

    needs = pathlib.Path(cffi.__file__).parents[1]
    site = next((folder / "lib").glob("python*/site-packages"))
    (site / "needs.pth").write_text(str(needs))
    return folder / "bin" / "python"


def run(*command, cwd):
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    return subprocess.run(
        [str(word) for word in command], cwd=cwd, env=environment, capture_output=True, text=True
    )


def test_one_wheel_for_every_python_3(wheel):
    name, version, python, abi, platform = wheel.stem.split("-")
    assert (name, version, python, abi) == ("mcvisi", mcvisi.__version__, "py3", "none")
    assert platform.startswith("manylinux_2_")
    names = zipfile.ZipFile(wheel).namelist()
    for wanted in ("libmcvisi.so", "bin/mcvisi", "py.typed", "_abi.py", "_verbs.py", "__init__.py"):
        assert "mcvisi/" + wanted in names
    assert not [n for n in names if n.endswith((".a", ".h")) or "test" in n]
    assert any(n.endswith("licenses/LICENSE") for n in names)
    libraries = {n.split("/")[-1].split("-")[0].split(".")[0] for n in names if ".libs/" in n}
    assert {"libtiff", "libpng16", "libjansson", "libOpenCL"} <= libraries
    assert not [name for name in libraries if name.startswith(("libX", "libxcb", "libfontconfig"))]
    assert not libraries & {"liblapack", "libblas", "libgfortran", "libquadmath", "libtmglib"}
    # Each has its licence, with the texts that it names; the stand-ins are the package's own.
    folder = next(n for n in names if n.endswith("/SOURCES")).rsplit("/", 1)[0] + "/"
    licences = {n[len(folder) :] for n in names if n.startswith(folder) and not n.endswith("/")}
    told = zipfile.ZipFile(wheel).read(folder + "SOURCES").decode().split("\n\n")[1]
    owners = dict(line.split(",")[0].split(": ") for line in told.splitlines())
    foreign = libraries - {"libcairo", "libjbig", "liblapacke", ""}
    assert {name.split("-")[0].split(".")[0] for name in owners} == foreign
    assert {*owners.values(), "SOURCES", "common/LGPL-2.1"} <= licences
    assert wheel.stat().st_size < 9e6


def test_it_renders_from_there(python, tmp_path):
    examples.bracket(tmp_path / "bracket.stl")
    script = (
        "import mcvisi as mv, numpy as np\n"
        "rig = mv.new('telecentric', 'bracket.stl', unit='mm', resolution=(96, 64))\n"
        "image = rig.render(spp=16)\n"
        "image.save('a.exr')\n"
        "print(mv.__file__, np.asarray(image).shape)\n"
    )
    ended = run(python, "-c", script, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert str(python.parents[1]) in ended.stdout and "(64, 96)" in ended.stdout
    assert ended.stderr == ""


def test_only_its_own_libraries_and_those_of_every_linux(python, tmp_path):
    library = next(python.parents[1].rglob("libmcvisi.so"))
    told = run("ldd", "-r", library, cwd=tmp_path).stdout
    assert "undefined symbol" not in told and "not found" not in told
    own = str(python.parents[1])
    known = (
        "linux-vdso",
        "libstdc++",
        "libm",
        "libgcc_s",
        "libc",
        "libz",
        "libpthread",
        "ld-linux",
    )
    for line in told.splitlines():
        name = line.split()[0].split("/")[-1]
        assert own in line or name.startswith(known), line


def test_labels_are_refused_with_a_sentence(python, tmp_path):
    script = (
        "import mcvisi as mv, numpy as np\n"
        "image = mv.Image(np.ones((9, 9)))\n"
        "try: image.measure(grid='g.png')\n"
        "except mv.Error as error: print(error)\n"
    )
    assert "draws no labels" in run(python, "-c", script, cwd=tmp_path).stdout


def test_the_program_is_in_it(python, tmp_path):
    ended = run(python.parent / "mcvisi", "--version", cwd=tmp_path)
    assert ended.returncode == 0 and mcvisi.__version__ in ended.stdout
    assert run(python.parent / "mcvisi", "render", "none.gltf", cwd=tmp_path).returncode == 3


def test_uninstalling_leaves_nothing(python, tmp_path):
    run(python, "-m", "pip", "uninstall", "--quiet", "--yes", "mcvisi", cwd=tmp_path)
    left = [p for p in python.parents[1].rglob("*mcvisi*") if p.suffix != ".pyc"]
    assert not left
