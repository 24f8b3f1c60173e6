# SPDX-License-Identifier: Apache-2.0
"""Finds an OpenCL driver that PyPI has brought, before the first use of OpenCL."""

from __future__ import annotations

import glob
import hashlib
import os
import re
import sys
from typing import Any, List, Mapping, Optional

SYSTEM_VENDORS = "/etc/OpenCL/vendors"
# The loader takes its drivers from the folder that this names.
VARIABLE = "OCL_ICD_VENDORS"
hint = ""


def packaged_pocl() -> Optional[str]:
    """The library of PyPI's pocl-binary-distribution. Its own .icd names a bare file, which the
    loader does not find; pyopencl itself is never imported for this."""
    for folder in sys.path:
        for path in sorted(
            glob.glob(os.path.join(glob.escape(folder), "pyopencl/.libs/libpocl-*"))
        ):
            return os.path.abspath(path)
    return None


def can_link() -> bool:
    """PyPI's PoCL links each kernel against libgcc and libc, by the linker ld. It ends the process
    where these are not there: whether a compiler can do the same is asked in a process of its own.
    """
    import subprocess

    command = ["cc", "-shared", "-x", "c", os.devnull, "-o", os.devnull]
    try:
        return subprocess.run(command, capture_output=True, timeout=10).returncode == 0
    except (OSError, subprocess.SubprocessError):
        return False


def knows_processor(device: Mapping[str, Any]) -> bool:
    """Compilers that are older than an x86 processor take it for "generic", at the end of PoCL's
    version, and then refuse that as a target."""
    return re.search(r"-x86_64\S*-generic\b", device["version"]) is None


def _cache_folder() -> str:
    base = os.environ.get("XDG_CACHE_HOME") or os.path.join(os.path.expanduser("~"), ".cache")
    return os.path.join(base, "mcvisi")


def _write(path: str, text: str) -> None:
    """Whole or not at all, as other processes may read it at the same time."""
    partial = "%s.%d" % (path, os.getpid())
    with open(partial, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(partial, path)


def _vendors_folder(drivers: List[str], pocl: str) -> str:
    # A name of its own for each set of drivers: two environments do not change each other's.
    name = hashlib.sha256("\n".join(drivers + [pocl]).encode()).hexdigest()[:16]
    folder = os.path.join(_cache_folder(), "vendors", name)
    os.makedirs(folder, mode=0o700, exist_ok=True)
    for driver in drivers:
        with open(driver, encoding="utf-8") as file:
            _write(os.path.join(folder, os.path.basename(driver)), file.read())
    _write(os.path.join(folder, "pocl-of-pypi.icd"), pocl + "\n")
    return folder


def find_opencl() -> None:
    """
    Sets OCL_ICD_VENDORS where PyPI's PoCL is installed and the system has no PoCL of its own.
    A variable that is set already stays. Without a folder to write in, nothing is changed.
    What a warning should say besides is in `hint`.
    """
    global hint
    if VARIABLE in os.environ:
        return
    drivers = sorted(glob.glob(os.path.join(SYSTEM_VENDORS, "*.icd")))
    pocl = packaged_pocl()
    if pocl is None or any("pocl" in os.path.basename(driver).lower() for driver in drivers):
        return
    if not can_link():
        hint = (
            "; PoCL of PyPI is there, but links kernels as a compiler does: install gcc, libc6-dev"
        )
        return
    try:
        os.environ[VARIABLE] = _vendors_folder(drivers, pocl)
    except OSError:
        return
