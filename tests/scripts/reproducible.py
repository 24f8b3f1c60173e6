#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Two builds of two copies in two folders are the same bytes.

    reproducible.py SOURCE FOLDER [PYTHON]

Compared are the program, both libraries, the flattened OpenCL programs, manual pages, completion
and, with a PYTHON that has what the package is built with, the wheel. Nothing is
optimised, which takes a third of the time: folders and times come into a file in other ways.
"""
import os
import pathlib
import shutil
import subprocess
import sys

FOLDERS = ("one", "a longer name/two")
FILES = ("mcvisi", "libmcvisi.a", "libmcvisi.so.0.0.0", "programs.c", "embedded.c",
         "share/man/man1/*", "share/bash-completion/completions/mcvisi", "python/mcvisi/_*.py*",
         "wheels/*.whl")


def run(*command):
    # A compiler's cache would give the second build the first one's objects.
    environment = os.environ | {"CCACHE_DISABLE": "1"}
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True,
                          check=False, env=environment)
    if done.returncode != 0:
        sys.exit("%s: exit code %d\n%s%s" % (" ".join(map(str, command)), done.returncode,
                                             done.stdout[-4000:], done.stderr[-4000:]))


def copy(source, target):
    """What a build needs, in another order of the folder's entries, with other times."""
    for name in ("host", "include", "kernels", "tools", "python"):
        shutil.copytree(source / name, target / name, copy_function=shutil.copyfile,
                        ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("CMakeLists.txt", "LICENSE", "README.md", "pyproject.toml"):
        shutil.copyfile(source / name, target / name)


def build(folder, python):
    target = folder / "build"
    if python:  # the wheel, in the same build folder
        run(python, "-m", "build", "--wheel", "--no-isolation", "--outdir", target / "plain",
            "-Cbuild-dir=%s" % target, "-Ccmake.build-type=None", folder)
        run(python, "-B", folder / "python/repair.py", next((target / "plain").glob("*.whl")),
            target / "wheels")
    else:
        run("cmake", "-S", folder, "-B", target, "-G", "Ninja", "-DMCV_TESTS=OFF",
            "-DCMAKE_BUILD_TYPE=None")
    run("cmake", "--build", target, "--target", "mcvisi_program", "mcvisi_shared", "manual_pages")
    return {str(path.relative_to(folder / "build")): path.read_bytes()
            for pattern in FILES for path in sorted((folder / "build").glob(pattern))}


def main():
    source, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    python = sys.argv[3] if len(sys.argv) > 3 else None
    built = []
    for name in FOLDERS:
        target = folder / name
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir(parents=True)
        copy(source, target.resolve())
        built.append(build(target.resolve(), python))
    one, two = built
    wrong = sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name))
    if wrong:
        sys.exit("they differ: " + ", ".join(wrong))
    if not {"mcvisi", "libmcvisi.a", "libmcvisi.so.0.0.0", "programs.c"} <= one.keys():
        sys.exit("only %s were built" % sorted(one))
    print("%d files, %d bytes, are the same" % (len(one), sum(map(len, one.values()))))
    shutil.rmtree(folder)


main()
