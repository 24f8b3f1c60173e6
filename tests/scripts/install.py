#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Programs are built from an installed library: install.py BUILD SOURCE CC CXX FOLDER.

Installs into FOLDER by DESTDIR, as packages are made, and moves that elsewhere. The examples in
examples/c are then built by find_package and by pkg-config, shared and static, and run by the
reference renderer. So is the program of docs/library.md, by the lines of that page.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys

LIBRARIES = ("libmcvisi.so", "libmcvisi.so.0", "libmcvisi.a")


def run(*command, **options):
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False, **options
    )
    if done.returncode != 0:
        sys.exit(
            "%s: exit code %d\n%s%s"
            % (" ".join(map(str, command)), done.returncode, done.stdout, done.stderr)
        )
    return done.stdout


def install(build, folder):
    """Staged below a prefix that does not exist, and moved: no path may lead back."""
    stage = folder / "stage"
    run("cmake", "--install", build, "--prefix", "/opt/mcvisi", env=os.environ | {"DESTDIR": stage})
    prefix = folder / "moved prefix"
    (stage / "opt/mcvisi").rename(prefix)
    headers = [p.name for p in (prefix / "include").rglob("*") if p.is_file()]
    if headers != ["mcvisi.h"]:
        sys.exit("include/ holds %s, must hold mcvisi.h alone" % headers)
    library = next(prefix.rglob("libmcvisi.so")).parent
    for name in LIBRARIES:
        if not (library / name).is_file():
            sys.exit("%s: is not installed" % name)
    for page in library.rglob("*"):
        if page.suffix in (".cmake", ".pc") and str(build) in page.read_text():
            sys.exit("%s: names the build folder" % page)
    return prefix, library


def try_programs(source, programs, environment):
    """What they print must be JSON with what they were asked for."""
    scene = source / "scenes/telecentric-edge.gltf"
    report = json.loads(run(programs / "render", scene, "reference", cwd=programs, env=environment))
    if report["size"] != [96, 64] or not all(
        (programs / name).is_file() for name in ("image.exr", "image.png", "grey.tif")
    ):
        sys.exit("render: %s" % report)
    lines = run(
        programs / "measure",
        scene,
        "sensors/camera/stopDiameter",
        "1mm",
        "2mm",
        "--device",
        "reference",
        cwd=programs,
        env=environment,
    ).splitlines()
    means = [json.loads(line.split(": ", 1)[1])["regions"][0]["mean"]["value"] for line in lines]
    # A stop of twice the diameter passes four times the light; half of the picture is black, and
    # the shadow's edge is as noisy as 64 samples of a part of the pixels make it.
    if len(means) != 2 or not 3.6 < means[1] / means[0] < 4.4:
        sys.exit("measure: %s" % lines)


def try_page(source, prefix, library, cc, folder):
    """The program and the lines of docs/library.md, as they stand."""
    page = (source / "docs/library.md").read_text(encoding="utf-8")
    code = page.split("```c\n")[1].split("```")[0]
    lines = [line.strip() for line in page.splitlines() if line.startswith("    ")]
    begin = next(i for i, line in enumerate(lines) if line.startswith("find_package"))
    cmake = ["cmake_minimum_required(VERSION 3.16)", "project(viewer C)"] + lines[begin : begin + 3]
    shell = next(line for line in lines if line.startswith("cc viewer.c"))
    folder.mkdir()
    (folder / "viewer.c").write_text(code)
    (folder / "CMakeLists.txt").write_text("\n".join(cmake) + "\n")
    shutil.copy(source / "scenes/telecentric-edge.gltf", folder / "rig.gltf")
    run(
        "cmake",
        "-S",
        folder,
        "-B",
        folder / "by cmake",
        "-DCMAKE_PREFIX_PATH=%s" % prefix,
        "-DCMAKE_C_COMPILER=%s" % cc,
    )
    run("cmake", "--build", folder / "by cmake")
    # The line has no quotes for blanks in the prefix.
    plain = folder.parent / "plain"
    plain.symlink_to(prefix)
    packages = plain / library.relative_to(prefix) / "pkgconfig"
    run("sh", "-c", shell, cwd=folder, env=os.environ | {"PKG_CONFIG_PATH": str(packages)})
    environment = os.environ | {
        "LD_LIBRARY_PATH": str(library),
        "MCVISI_OPENCL_DEVICE": "reference",
    }
    for program in (folder / "by cmake/viewer", folder / "viewer"):
        run(program, cwd=folder, env=environment)
        (folder / "rig.exr").unlink()


def main(build, source, cc, cxx, folder):
    build, source, folder = map(pathlib.Path, (build, source, folder))
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    prefix, library = install(build, folder)
    examples = source / "examples/c"

    by_cmake = folder / "by cmake"
    run(
        "cmake",
        "-S",
        examples,
        "-B",
        by_cmake,
        "-DCMAKE_PREFIX_PATH=%s" % prefix,
        "-DCMAKE_C_COMPILER=%s" % cc,
        "-DCMAKE_CXX_COMPILER=%s" % cxx,
    )
    run("cmake", "--build", by_cmake)
    try_programs(source, by_cmake, os.environ)

    try_page(source, prefix, library, cc, folder / "page")

    environment = os.environ | {
        "PKG_CONFIG_PATH": str(library / "pkgconfig"),
        "LD_LIBRARY_PATH": str(library),
    }
    for kind in ("shared", "static"):
        programs = folder / kind
        programs.mkdir()
        # A shell reads what pkg-config prints, as in a Makefile: the prefix has a blank.
        flags = (
            "$(pkg-config --cflags --libs mcvisi)"
            if kind == "shared"
            else "$(pkg-config --cflags mcvisi) '%s' $(pkg-config --libs --static mcvisi)"
            % (library / "libmcvisi.a")
        )
        if kind == "static":
            (library / "libmcvisi.so").rename(library / "libmcvisi.so.hidden")
        for compiler, name in ((cc, "render.c"), (cxx, "measure.cpp")):
            run(
                "sh",
                "-c",
                "eval %s -Wall -Wextra -Werror -pedantic '%s' -o '%s' \"%s\""
                % (compiler, examples / name, programs / pathlib.Path(name).stem, flags),
                env=environment,
            )
        try_programs(source, programs, environment)
    print("built by find_package and pkg-config, shared and static")


if __name__ == "__main__":
    main(*sys.argv[1:])
