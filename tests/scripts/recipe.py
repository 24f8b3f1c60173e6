#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Run the commands of README.md, "Your first measurement", on a bracket, and compare what they
measure with its CAD dimensions.

recipe.py MCVISI README.md QUICK-START.md FOLDER

The first line writes the bracket, whose mesh must be closed. Where trimesh and manifold3d can be
imported another bracket from that CAD library goes the same way. Only --time is replaced, by --spp 16, so that the noise does not
depend on the machine. The quick start must hold the same lines.
"""

import json
import math
import os
import re
import shlex
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import bracket_part  # noqa: E402

CAD = bracket_part.DEFAULTS
HEADING = "## Your first measurement\n"


def commands_of(page):
    """The first six indented lines below the heading: one that writes part.stl, then mcvisi's."""
    section = open(page, encoding="utf-8").read().split(HEADING)[1].split("\n#")[0]
    code = [line for line in section.splitlines() if line.startswith("    ")][:6]
    lines = [shlex.split(line, comments=True) for line in code]
    verbs = [" ".join(line[:2]) for line in lines]
    expected = ["mcvisi " + verb for verb in ("new", "check", "render", "camera", "measure")]
    if lines[0][0] != "python3" or lines[0][2:] != ["part.stl"] or verbs[1:] != expected:
        sys.exit("%s: the recipe has other lines: %s" % (page, lines))
    return lines


def run(program, words):
    result = subprocess.run([program] + words, capture_output=True, text=True)
    if result.returncode != 0:
        sys.exit(
            "mcvisi %s: exit code %d\n%s%s"
            % (" ".join(words), result.returncode, result.stdout, result.stderr)
        )
    return result.stdout


def render(program, lines):
    for line in lines:
        words = line[1:]
        if "--time" in words:
            at = words.index("--time")
            words[at : at + 2] = ["--spp", "16"]
        run(program, words)


failures = []


def compare(what, measured, predicted, slack=0.0):
    """measured: {"value", "uncertainty"} [m]; a right program misses ± 4 uncertainties once in
    16000 figures."""
    off = measured["value"] - predicted
    bound = 4 * measured["uncertainty"] + slack
    print(
        "  %-40s %.5f ± %.5f mm, predicted %.5f mm, off %+.2f µm, bound %.2f µm"
        % (
            what,
            1e3 * measured["value"],
            1e3 * measured["uncertainty"],
            1e3 * predicted,
            1e6 * off,
            1e6 * bound,
        )
    )
    if not abs(off) <= bound:
        failures.append(what)


def growth_of(program, rig):
    """What check says that an edge grows [m]; by hand 2/(3π) a T, a = m/(2N)."""
    sensor = json.loads(run(program, ["check", rig, "--json"]))["sensors"][0]
    growth = sensor["silhouettes"]["growth_of_edge"]["value"]
    by_hand = (
        2
        / (3 * math.pi)
        * sensor["magnification"]
        / (2 * sensor["fNumber"])
        * CAD["thickness"]
        * 1e-3
    )
    if abs(growth / by_hand - 1) > 1e-6:
        sys.exit("check says that an edge grows by %g m, not by %g m" % (growth, by_hand))
    return growth


def measured_by(program, words):
    """The lists of the report, by name."""
    report = json.loads(run(program, words + ["--json"]))
    return {
        kind: {entry["name"]: entry for entry in report.get(kind, [])}
        for kind in ("distances", "circles")
    }


def measure(program, line):
    growth = growth_of(program, "part-telecentric.gltf")
    words = line[1:]
    people = run(program, words)
    if not re.search(r"length +[0-9.]+ ± [0-9.e-]+ mm", people):
        sys.exit("the last command of the recipe does not end in mm:\n" + people)
    # With --nominal the CAD's, without it what geometry and thickness predict.
    for nominal in (True, False):
        chosen = words if nominal else [word for word in words if word != "--nominal"]
        found = measured_by(program, chosen)
        grown = 0 if nominal else growth
        compare(
            "width" + (", nominal" if nominal else ""),
            found["distances"]["left to right"]["length"],
            1e-3 * CAD["width"] + 2 * grown,
            0 if nominal else 0.02 * growth,
        )
        for name, diameter in (("bore", CAD["bore"]), ("a", CAD["hole"]), ("b", CAD["hole"])):
            compare(
                "diameter of %s%s" % (name, ", nominal" if nominal else ""),
                found["circles"][name]["diameter_length"],
                1e-3 * diameter - 2 * grown,
                0 if nominal else 0.02 * growth,
            )
        # From the bore to each hole; growth moves no centre.
        for name in ("a", "b"):
            compare(
                "bore to %s%s" % (name, ", nominal" if nominal else ""),
                found["distances"]["bore to " + name]["length"],
                1e-3 * math.hypot(CAD["pitch_x"], CAD["pitch_y"]) / 2,
            )


def check_bracket(program, lines, what):
    print(what)
    render(program, lines[1:5])
    measure(program, lines[5])


def check_mesh():
    """Each side of a triangle is the side of one other, the other way round; the volume is that of
    the plate without its holes."""
    triangles = bracket_part.bracket(**CAD)
    sides = [side for a, b, c in triangles for side in ((a, b), (b, c), (c, a))]
    known = set(sides)
    if len(known) != len(sides) or any((b, a) not in known for a, b in sides):
        sys.exit("the bracket's mesh is open")
    volume = sum(
        a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
        for a, b, c in triangles
    )
    area = CAD["width"] * CAD["height"] - math.pi / 4 * (CAD["bore"] ** 2 + 4 * CAD["hole"] ** 2)
    if abs(volume / 6 / (area * CAD["thickness"]) - 1) > 1e-9:
        sys.exit("the bracket has %g mm³ instead of %g" % (volume / 6, area * CAD["thickness"]))


def main():
    check_mesh()
    program, readme, quick_start = (os.path.abspath(path) for path in sys.argv[1:4])
    folder = sys.argv[4]
    lines = commands_of(readme)
    if commands_of(quick_start) != lines:
        sys.exit("%s and %s have different recipes" % (readme, quick_start))
    os.makedirs(folder, exist_ok=True)
    os.chdir(folder)
    for name in os.listdir("."):
        os.remove(name)
    # The script's path is relative to the README's folder.
    script = os.path.join(os.path.dirname(readme), lines[0][1])
    subprocess.run([sys.executable, "-B", script] + lines[0][2:], check=True)
    check_bracket(program, lines, "a bracket by the standard library")
    try:
        import manifold3d  # noqa: F401
        import trimesh
    except ImportError:
        print("trimesh and manifold3d are not installed: no bracket from a CAD library")
    else:
        plate = trimesh.creation.box((CAD["width"], CAD["height"], CAD["thickness"]))
        plate.apply_translation((0, 0, CAD["thickness"] / 2))
        places = [(0, 0, CAD["bore"])] + [
            (sx * CAD["pitch_x"] / 2, sy * CAD["pitch_y"] / 2, CAD["hole"])
            for sx in (-1, 1)
            for sy in (-1, 1)
        ]
        step = 2 * math.pi / CAD["segments"]
        for x, y, diameter in places:
            radius = diameter / 2 * math.sqrt(step / math.sin(step))
            drill = trimesh.creation.cylinder(
                radius, 3 * CAD["thickness"], sections=CAD["segments"]
            )
            drill.apply_translation((x, y, CAD["thickness"] / 2))
            plate = plate.difference(drill, engine="manifold")
        os.remove("part-telecentric.gltf")
        plate.export("part.stl")
        check_bracket(program, lines, "a bracket by trimesh")
    if failures:
        sys.exit("outside of the stated uncertainty: " + ", ".join(failures))


if __name__ == "__main__":
    main()
