#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The lines of docs/long-renders.md for many machines run as they are printed.

    clusters.py PROGRAM SOURCES FOLDER

GNU parallel runs the parts of a sweep. A Slurm array is simulated: its script runs once for each
task, with the variables that Slurm sets; one task is ended by SIGTERM, as Slurm does, and queued
again. The results are those of one sweep and one render.
"""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

program, sources, folder = (pathlib.Path(p).resolve() for p in sys.argv[1:])
shutil.rmtree(folder, ignore_errors=True)
folder.mkdir(parents=True)
(folder / "bin").mkdir()
(folder / "bin/mcvisi").symlink_to(program)
environment = {**os.environ, "PATH": "%s:%s" % (folder / "bin", os.environ["PATH"])}
page = (sources / "docs/long-renders.md").read_text(encoding="utf-8")


def example(name):
    found = re.search(r"<!-- example: %s -->\n```sh\n(.*?)```" % name, page, re.S)
    if not found:
        sys.exit("docs/long-renders.md: there is no example %s" % name)
    return found[1]


def run(*command, code=0, **options):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True,
                          env=options.pop("env", environment), **options)
    if done.returncode != code:
        sys.exit("%s: exit code %d, not %d:\n%s%s" % (
            " ".join(command), done.returncode, code, done.stdout, done.stderr))
    return done.stdout + done.stderr


def rows(name):
    """The rows of a table without their seconds."""
    lines = (folder / name).read_text(encoding="utf-8").splitlines()
    seconds = lines[0].split(",").index("seconds")
    return [[v for i, v in enumerate(line.split(",")) if i != seconds] for line in lines]


def pixels(name):
    """What measuring says of an image: its mean and noise to all digits."""
    return run("mcvisi", "measure", name, "--json")


# The scene: a small image of the shipped one.
text = (sources / "scenes/beam.gltf").read_text(encoding="utf-8")
(folder / "part.gltf").write_text(text.replace("[320, 240]", "[24, 16]"), encoding="utf-8")
(folder / "edge.json").write_text(
    '{"rig": "part.gltf", "vary": ["emitters/beam/power=1..12:12"], "metric": ["mean"],'
    ' "spp": 4, "resolution": "8x8", "precision": "double"}', encoding="utf-8")

if shutil.which("parallel"):
    run("sh", "-e", "-c", example("parallel"))
    run("mcvisi", "sweep", "edge.json", "-o", "whole.csv")
    if rows("edge-all.csv") != rows("whole.csv"):
        sys.exit("the parts that GNU parallel has run are not the whole sweep")
    print("GNU parallel: the rows of one sweep")
else:
    print("GNU parallel is not installed: its lines were not run")

script = folder / "job.sh"
script.write_text(example("slurm"), encoding="utf-8")
tasks = re.search(r"--array=0-(\d+)", example("slurm"))
for task in range(int(tasks[1]) + 1):
    slurm = {**environment, "SLURM_ARRAY_TASK_ID": str(task), "SLURM_CPUS_PER_TASK": "2",
             "SLURM_TMPDIR": str(folder), "SLURM_JOB_ID": "7"}
    if task == 3:  # the time ends while it renders
        job = subprocess.Popen(["bash", "job.sh"], cwd=folder, env=slurm,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(0.3)
        job.send_signal(signal.SIGTERM)
        if job.wait() not in (0, 143, -signal.SIGTERM):
            sys.exit("a task that was terminated has exit code %d" % job.returncode)
    run("bash", "job.sh", env=slurm)
run("sh", "-e", "-c", example("slurm-merge"))
run("mcvisi", "render", "part.gltf", "--samples", "0:512", "-o", "whole.exr",
    "--checkpoint", "off")
if pixels("part.exr").replace("part.exr", "") != pixels("whole.exr").replace("whole.exr", ""):
    sys.exit("the parts of the Slurm array are not the whole render")
print("Slurm array: the image of one render")
