#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""
draw.py [FOLDER]   draws the elements into FOLDER, by default docs/elements/drawings

One SVG file for each element. Python's standard library only; the same bytes everywhere.
"""

import importlib
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
MODULES = ("sensors", "emitters", "lights", "presets", "materials", "roughness", "surfaces",
           "defects")


def drawings():
    """The name of each drawing and its SVG text."""
    files = {}
    for module in MODULES:
        for name, sketch in importlib.import_module("draw_" + module).DRAWINGS.items():
            assert name not in files, "two drawings are called %s" % name
            files[name + ".svg"] = sketch().svg()
    return files


def main(arguments):
    if len(arguments) > 1 or arguments[:1] in (["-h"], ["--help"]):
        print(__doc__.strip())
        return 0 if len(arguments) == 1 else 2
    folder = arguments[0] if arguments else os.path.join(HERE, "drawings")
    os.makedirs(folder, exist_ok=True)
    for name, text in drawings().items():
        with open(os.path.join(folder, name), "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
    return 0


if __name__ == "__main__":
    sys.path.insert(0, HERE)
    sys.exit(main(sys.argv[1:]))
