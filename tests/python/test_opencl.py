# SPDX-License-Identifier: Apache-2.0
"""How OpenCL is found, and what happens without."""

import os
import pathlib
import stat
import subprocess
import sys
import warnings

import pytest
from mcvisi import opencl, session


def put_compiler(place, words):
    path = place / "bin" / "cc"
    path.write_text("#!/bin/sh\n%s\n" % words)
    path.chmod(0o755)


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A system without drivers, a cache, and an environment with PyPI's PoCL."""
    vendors, site = tmp_path / "vendors", tmp_path / "site [packages]"
    (site / "pyopencl" / ".libs").mkdir(parents=True)
    vendors.mkdir()
    monkeypatch.setenv(opencl.VARIABLE, "")  # so that what a test sets goes with it
    monkeypatch.delenv(opencl.VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(opencl, "SYSTEM_VENDORS", str(vendors))
    monkeypatch.setattr(sys, "path", [str(site)])
    (tmp_path / "bin").mkdir()
    put_compiler(tmp_path, "exit 0")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    return tmp_path


def put_pocl(place):
    path = place / "site [packages]" / "pyopencl" / ".libs" / "libpocl-21062cec.so.2.8.0"
    path.write_bytes(b"")
    return path


def drivers():
    folder = pathlib.Path(os.environ[opencl.VARIABLE])
    return {path.name: path.read_text().strip() for path in folder.iterdir()}


def test_nothing_to_find(place):
    opencl.find_opencl()
    assert opencl.VARIABLE not in os.environ and not (place / "cache").exists()


def test_pocl_of_pypi_by_its_absolute_path(place):
    path = put_pocl(place)
    opencl.find_opencl()
    assert drivers() == {"pocl-of-pypi.icd": str(path)}
    assert stat.S_IMODE(os.stat(os.environ[opencl.VARIABLE]).st_mode) == 0o700


@pytest.mark.parametrize("compiler", [None, "exit 1"])
def test_pocl_that_cannot_link_would_end_the_process(place, monkeypatch, compiler):
    put_pocl(place)
    if compiler is None:
        (place / "bin" / "cc").unlink()
    else:
        put_compiler(place, compiler)
    monkeypatch.setattr(opencl, "hint", "")
    opencl.find_opencl()
    assert opencl.VARIABLE not in os.environ and "gcc" in opencl.hint


def test_beside_the_drivers_of_the_system(place):
    (place / "vendors" / "nvidia.icd").write_text("libnvidia-opencl.so.1\n")
    path = put_pocl(place)
    opencl.find_opencl()
    assert drivers() == {"pocl-of-pypi.icd": str(path), "nvidia.icd": "libnvidia-opencl.so.1"}


def test_the_system_s_pocl_comes_first(place):
    (place / "vendors" / "pocl.icd").write_text("libpocl.so.2\n")
    put_pocl(place)
    opencl.find_opencl()
    assert opencl.VARIABLE not in os.environ


def test_a_variable_that_is_set_stays(place, monkeypatch):
    put_pocl(place)
    monkeypatch.setenv(opencl.VARIABLE, "/mine")
    opencl.find_opencl()
    assert os.environ[opencl.VARIABLE] == "/mine"


def test_without_a_cache_folder(place, monkeypatch):
    put_pocl(place)
    (place / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(place / "file"))
    opencl.find_opencl()
    assert opencl.VARIABLE not in os.environ


def test_without_opencl_the_reference_renderer_is_used(folder, tmp_path):
    script = (
        "import mcvisi as mv, warnings\n"
        "rig = mv.new('telecentric', 'bracket.stl', unit='mm', resolution=(16, 12))\n"
        "with warnings.catch_warnings(record=True) as told:\n"
        "    warnings.simplefilter('always')\n"
        "    for _ in range(2):\n"
        "        image = rig.render(spp=4, progress=False)\n"
        "assert 'reference' in image.report['device'], image.report\n"
        "assert len(told) == 1 and 'mcvisi[cpu]' in str(told[0].message)\n"
        "assert told[0].filename == '<string>', told[0].filename\n"
    )
    environment = {**os.environ, opencl.VARIABLE: str(tmp_path)}
    ended = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr


@pytest.mark.parametrize("target, known", [("generic", False), ("skylake-avx512", True)])
def test_a_compiler_that_does_not_know_the_processor(monkeypatch, target, known):
    # What PoCL of PyPI says of a processor that is newer than it; each of its kernels fails.
    version = "OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-%s, driver 3.0-rc2" % target
    monkeypatch.setattr(session, "devices", lambda: [{"name": "a processor", "version": version}])
    monkeypatch.setattr(session, "_found", False)
    monkeypatch.setattr(session, "_warned", False)
    monkeypatch.setattr(opencl, "hint", "")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assert session._has_device() == session._has_device() == known
    assert ["does not know this processor" in str(w.message) for w in told] == [True] * (not known)
