#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
generate.py [DIRECTORY]   writes every scene, by default beside this file
generate.py --check       writes none; says which of those beside this file differ

Python's standard library only. Coordinates are stored as float32, so the last bit of a mathematics
library's sine does not show (once in 10^4 files, if two libraries differ at all)."""

import os
import sys

import basics
import conveyor
import deflectometry
import experiments
import images
import lights
import optics
import part
import report
import setups
import surfaces

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = (
    report,
    part,
    basics,
    images,
    lights,
    setups,
    conveyor,
    experiments,
    surfaces,
    optics,
    deflectometry,
)


def main(arguments):
    if len(arguments) > 1 or arguments[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0 if len(arguments) == 1 else 2
    files = {}
    for module in MODULES:
        files.update(module.files())
    if arguments == ["--check"]:
        return check(files)
    for name, data in files.items():
        with open(os.path.join(arguments[0] if arguments else HERE, name), "wb") as file:
            file.write(data)
    return 0


def check(files):
    differ = 0
    for name, data in files.items():
        try:
            with open(os.path.join(HERE, name), "rb") as file:
                shipped = file.read()
        except FileNotFoundError:
            print("%s: missing; scenes/generate.py writes it" % name)
            differ += 1
            continue
        if shipped != data:
            first = next(
                (i for i, (a, b) in enumerate(zip(shipped, data)) if a != b),
                min(len(shipped), len(data)),
            )
            print(
                "%s: %d bytes, %d generated, first difference at byte %d"
                % (name, len(shipped), len(data), first)
            )
            differ += 1
    strangers = sorted(
        name
        for name in os.listdir(HERE)
        if name.endswith((".gltf", ".glb")) and name not in files and name != part.SOURCE
    )
    for name in strangers:
        print("%s: has no generator" % name)
    print("%d scenes compared, %d differ" % (len(files), differ))
    return 1 if differ or strangers else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
