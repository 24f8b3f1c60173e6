# SPDX-License-Identifier: Apache-2.0
"""The wheel: built, installed into an empty environment, and used from there. Slow: it compiles."""

import os
import pathlib
import subprocess
import sys
import venv
import zipfile

import bracket
import mcvisi
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheels")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", folder, ROOT]
    built = subprocess.run(command, capture_output=True, text=True)
    assert built.returncode == 0, built.stdout[-3000:] + built.stderr[-3000:]
    return next(folder.glob("*.whl"))


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
    assert platform.startswith(("linux_", "manylinux"))
    names = zipfile.ZipFile(wheel).namelist()
    for wanted in ("libmcvisi.so", "bin/mcvisi", "py.typed", "_abi.py", "_verbs.py", "__init__.py"):
        assert "mcvisi/" + wanted in names
    assert not [n for n in names if n.endswith((".a", ".h")) or "test" in n]
    assert any(n.endswith("licenses/LICENSE") for n in names)
    assert wheel.stat().st_size < 10e6


def test_it_renders_from_there(python, tmp_path):
    bracket.write(tmp_path / "bracket.stl")
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


def test_the_program_is_in_it(python, tmp_path):
    ended = run(python.parent / "mcvisi", "--version", cwd=tmp_path)
    assert ended.returncode == 0 and mcvisi.__version__ in ended.stdout
    assert run(python.parent / "mcvisi", "render", "none.gltf", cwd=tmp_path).returncode == 3


def test_uninstalling_leaves_nothing(python, tmp_path):
    run(python, "-m", "pip", "uninstall", "--quiet", "--yes", "mcvisi", cwd=tmp_path)
    left = [p for p in python.parents[1].rglob("*mcvisi*") if p.suffix != ".pyc"]
    assert not left
