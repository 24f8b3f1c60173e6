#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""An optimisation reaches what a grid of 40 x 40 renders finds, within 2 %, by a tenth of them.

optimum.py PROGRAM SOURCE FOLDER [ring|bubble ...]

ring    the most light of a scratch under a ring light, by the ring's distance and outer diameter
bubble  the signal of a bubble in glass over the shot noise of the light around it, by the panel's
        half-angle and the camera's f-number

The best of many noisy values is too good (the winner's curse). So the grid's ten best points are
rendered again with other random numbers and many samples; the best of these is the grid's answer.
The optimum is rendered with the same random numbers and samples.
"""
import csv
import json
import pathlib
import resource
import subprocess
import sys

STEPS = 40
SHARE = 0.1  # of the grid's renders
LOSS = 0.02  # of the grid's best value
CHECKED = 10  # points of the grid
SEED = 1000  # of the check; searches begin with 0

RING = {
    "vary": ["nodes/light/distance=6mm..21mm", "emitters/light/outerDiameter=52mm..70mm"],
    "measure": ["--region", "scratch=@part:0mm,0mm,3mm,0.64mm,8mm", "--metric",
                "value:=scratch.mean"],
    "samples": {"search": 64, "check": 4096},
}
BUBBLE = {
    "vary": ["emitters/light/halfAngle=1deg..45deg:log", "sensors/camera/fNumber=1.4..11:log"],
    "measure": ["--region", "bubble=@part:0mm,0mm,0.5mm,0.4mm,0.4mm", "--region",
                "clear=@part:1.4mm,0mm,0.5mm,0.8mm,2mm", "--metric",
                "value:=abs(bubble.mean-clear.mean)/sqrt(clear.mean)"],
    "samples": {"search": 64, "check": 4096},
}


def run(program, folder, words):
    done = subprocess.run([program, *words], cwd=folder, check=False, capture_output=True, text=True)
    if done.returncode:
        command = " ".join([pathlib.Path(program).name, *words])
        sys.exit(f"{command}: exit code {done.returncode}: {done.stderr}")
    return done.stdout


def make_ring(program, source, folder):
    run(sys.executable, folder, [f"{source}/docs/tutorials/parts.py", "scratched", "block.stl"])
    run(program, folder, ["new", "telecentric", "block.stl", "--unit", "mm", "--material", "iron",
                          "--light", "darkfield", "--resolution", "80x60", "-o", "ring.gltf",
                          "--force"])
    return "ring.gltf"


def make_bubble(program, source, folder):
    run(sys.executable, folder, [f"{source}/docs/tutorials/parts.py", "plain", "glass.stl"])
    run(program, folder, ["new", "telecentric", "glass.stl", "--unit", "mm", "--material", "N-BK7",
                          "--light", "backlight", "--pixel-size", "100um", "--field-of-view", "4mm",
                          "--resolution", "40x30", "-o", "glass.gltf", "--force"])
    (folder / "bubble.gltf").unlink(missing_ok=True)
    run(program, folder, ["defect", "glass.gltf", "bubble", "--node", "part", "--at",
                          "0mm,0mm,0.5mm", "--size", "0.4mm", "-o", "bubble.gltf"])
    return "bubble.gltf"


def all_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def rows_of(path):
    """Those that did not fail."""
    return [row for row in all_rows(path) if not row["message"]]


def steps_of(item):
    """FROM..TO:log has its steps before the scale."""
    span, _, scale = item.partition(":")
    return f"{span}:{STEPS}" + (f":{scale}" if scale else "")


def name_of(item):
    return item.partition("=")[0].rpartition("/")[2]


def checked(program, folder, rig, case, points):
    """The value and its standard uncertainty at each point, by one set of random numbers."""
    words = ["sweep", rig, "--design", "list", "-o", "check.csv", "--force", "--seed", str(SEED),
             "--spp", str(case["samples"]["check"]), *case["measure"]]
    for item in case["vary"]:
        path = item.partition("=")[0]
        words += ["--vary", path + "=" + ",".join(point[name_of(item)] for point in points)]
    run(program, folder, words)
    return [(float(row["value"]), float(row["value_u"])) for row in rows_of(folder / "check.csv")]


def search(program, folder, rig, case):
    """The optimum, and how many renders it took, those that failed among them."""
    words = ["optimize", rig, "-o", "optimum.csv", "--force", "--objective", "value=largest",
             "--spp", str(case["samples"]["search"]), "--json", *case["measure"]]
    for item in case["vary"]:
        words += ["--vary", item]
    report = json.loads(run(program, folder, words))
    best = {name: repr(value) for name, value in report["winner"]["parameters"].items()}
    return best, len(all_rows(folder / "optimum.csv"))


def grid(program, folder, rig, case):
    words = ["sweep", rig, "-o", "grid.csv", "--force", "--spp", str(case["samples"]["search"]),
             *case["measure"]]
    for item in case["vary"]:
        words += ["--vary", steps_of(item)]
    run(program, folder, words)
    rows = rows_of(folder / "grid.csv")
    if len(rows) != STEPS**2:
        sys.exit(f"the grid has {len(rows)} rows: must be {STEPS ** 2}")
    return sorted(rows, key=lambda row: -float(row["value"]))[:CHECKED]


def compare(program, source, folder, name):
    make, case = {"ring": (make_ring, RING), "bubble": (make_bubble, BUBBLE)}[name]
    rig = make(program, source, folder)
    best, renders = search(program, folder, rig, case)
    points = grid(program, folder, rig, case)
    (found, u_found), *values = checked(program, folder, rig, case, [best, *points])
    top, u_top = max(values)
    u = ((u_found / found) ** 2 + (u_top / top) ** 2) ** 0.5
    at = ", ".join(f"{name_of(item)} {float(best[name_of(item)]):.4g}" for item in case["vary"])
    print(f"{name}: {renders} renders at {at}: {found:.5g}; grid of {STEPS ** 2}: {top:.5g}: "
          f"{found / top - 1:+.2%} ± {u:.2%}", flush=True)
    # What is known to u must be known better than the loss that is allowed, by two of its u.
    faults = []
    if u > LOSS / 2:
        faults.append(f"{name}: the comparison is uncertain by {u:.2%}: must be {LOSS / 2:.1%}")
    if found < (1 - LOSS) * top:
        faults.append(f"{name}: {1 - found / top:.2%} below the grid's best: must be {LOSS:.0%}")
    if renders > SHARE * STEPS**2:
        faults.append(f"{name}: {renders} renders: must be {SHARE * STEPS ** 2:.0f} at most")
    return faults


def main():
    program, source, folder = sys.argv[1:4]
    folder = pathlib.Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    faults = []
    for name in sys.argv[4:] or ["ring", "bubble"]:
        faults += compare(str(pathlib.Path(program).resolve()), pathlib.Path(source).resolve(),
                          folder, name)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{used.ru_utime + used.ru_stime:.0f} s of processor time")
    sys.exit("\n".join(faults) or None)


if __name__ == "__main__":
    main()
