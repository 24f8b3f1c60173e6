#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders shipped scenes, small and in both schedules, with buffers that end at a page nobody may touch.

    cl_fence.py PROGRAM FENCE.so FOLDER [SCENE...]   all scenes, or these

A kernel that reads or writes beyond a buffer, or writes before it, is a finding. A planted one must
be found. Where a driver keeps buffers elsewhere than in the host's memory, the test says nothing.
"""

import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
import same_bits  # pylint: disable=wrong-import-position

PLANTED = ("kernels/probe.cl", "results[4 * i + 3]", "results[4 * i + 4]")  # one float too far
BEYOND = -11  # SIGSEGV


def fenced(program, fence, folder, arguments, **more):
    """The ended process, the number of buffers, and how many have written surroundings."""
    count = folder / "count"
    count.unlink(missing_ok=True)
    environment = dict(os.environ, OPENCL_LAYERS=str(fence), MCV_CL_COUNT=str(count), **more)
    done = subprocess.run([program, *arguments], cwd=folder, env=environment, check=False,
                          capture_output=True, text=True, errors="replace")
    numbers = count.read_text().split() if count.exists() else (0, 0)
    return done, int(numbers[0]), int(numbers[1])


def is_found(program, fence, folder):
    """Whether a kernel that writes beyond its buffer ends the process."""
    copy = folder / "planted"
    for part in ("kernels", "include"):
        shutil.copytree(same_bits.ROOT / part, copy / part)
    path = copy / PLANTED[0]
    path.write_text(path.read_text().replace(PLANTED[1], PLANTED[2]))
    arguments = ["render", str(same_bits.ROOT / "scenes/beam.gltf"), "--resolution", "4x4", "--spp",
                 "4", "-o", "planted.exr"]
    return fenced(program, fence, folder, arguments, MCVISI_KERNEL_DIR=str(copy))[0].returncode == BEYOND


def main(program, fence, folder, *names):
    folder = pathlib.Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    renders = buffers = findings = 0
    for scene in same_bits.scenes(names):
        for sensor in same_bits.sensors(program, scene):
            for schedule in same_bits.SCHEDULES:
                size = same_bits.RESOLUTIONS.get(sensor["type"], same_bits.RESOLUTION)
                arguments = ["render", str(scene), "--sensor", sensor["name"], "--schedule", schedule,
                             *same_bits.OPTIONS, *same_bits.light_paths_by_rule(program), "-o",
                             "image.exr"]
                done, count, written = fenced(program, fence, folder,
                                              [*arguments, "--resolution", size])
                if done.returncode == same_bits.WRONG_USAGE:  # sensors that keep their size
                    done, count, written = fenced(program, fence, folder, arguments)
                if done.returncode == 0 and count == 0:
                    print("skipped: the OpenCL loader knows no layers")
                    return 0
                renders += 1
                buffers += count
                if done.returncode != 0 or written:
                    findings += 1
                    print("%s, %s, %s: exit code %d, %d of %d buffers: %s" %
                          (scene.stem, sensor["name"], schedule, done.returncode, written, count,
                           done.stderr[-300:]), flush=True)
    if not is_found(program, fence, folder):
        findings += 1
        print("a planted write beyond a buffer was not found")
    print("%d renders, %d buffers, %d findings" % (renders, buffers, findings))
    return 1 if findings or renders == 0 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
