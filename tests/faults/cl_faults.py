#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails calls of OpenCL in the program, one at a time, by a layer between program and driver.

    cl_faults.py PROGRAM LAYER.so SOURCES FOLDER [all]

By default the first and the last call of each function fail, in one render. all: each call of each
function fails in five kinds of work, in the first one with each of four codes; and from some calls on
all calls fail, as of a lost device.

A run ends with exit code 4 and a sentence that names the code, and leaves no file; or with exit code 0
and the very files of the undisturbed run, where the call did not matter. All objects are released but
the context and the programs that the process keeps for its next render.
"""

import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
from same_bits import pixels_digest  # pylint: disable=wrong-import-position

CODES = {"CL_OUT_OF_RESOURCES": -5, "CL_MEM_OBJECT_ALLOCATION_FAILURE": -4,
         "CL_OUT_OF_HOST_MEMORY": -6, "CL_DEVICE_NOT_AVAILABLE": -2}
DEVICE = 4  # the exit code of a failing device
TIMEOUT = 60  # an undisturbed run takes 0.2 s
KEPT = {"context": 1, "program": 4}  # host/cl/program_cache.c
# Without these a run is as good: times of launches, large pages, the wording of an error, the wait for
# answers that nobody needs any more.
HARMLESS = re.compile("clWaitForEvents|clRelease|clRetainProgram|clGetEventProfilingInfo|clGetKernelInfo|clEnqueueMapBuffer|"
                      "clEnqueueUnmapMemObject|clGetProgramInfo|clGetPlatformInfo")
SMALL = ["--resolution", "4x4", "--spp", "4", "-o", "out.exr"]
WORK = (["render", "scenes/beam.gltf", "--schedule", "tile", *SMALL],
        ["render", "scenes/beam.gltf", "--schedule", "stream", *SMALL],
        ["render", "scenes/caustic.gltf", "--schedule", "tile", *SMALL],
        ["render", "scenes/caustic.gltf", "--schedule", "stream", *SMALL],
        ["render", "scenes/diffuse-box.gltf", "--schedule", "tile", "--adaptive", *SMALL])


def contents(folder):
    """The names of the files, and the pixels of images."""
    return {path.name: pixels_digest(path) if path.suffix == ".exr" else None
            for path in folder.iterdir()}


class Runs:
    def __init__(self, program, layer, sources, folder):
        self.program, self.layer = program, layer
        self.sources, self.folder = pathlib.Path(sources), pathlib.Path(folder)
        shutil.rmtree(folder, ignore_errors=True)
        self.findings, self.count = [], 0

    def run(self, arguments, where, fault=None, at=0, code=0, stays=False):
        """The ended process, its calls and what it left, and the files."""
        folder = self.folder / where
        folder.mkdir(parents=True)
        counts = self.folder / (where + ".count")
        environment = dict(os.environ, OPENCL_LAYERS=str(self.layer), MCV_CL_COUNT=str(counts))
        if fault:
            environment.update(MCV_CL_FAULT=fault, MCV_CL_AT=str(at), MCV_CL_ERROR=str(code))
        if stays:
            environment["MCV_CL_STAYS"] = "1"
        words = [str(self.sources / word) if word.startswith("scenes/") else word
                 for word in arguments]
        try:
            done = subprocess.run([self.program, *words], cwd=folder, env=environment, check=False,
                                  timeout=TIMEOUT, capture_output=True, text=True, errors="replace")
        except subprocess.TimeoutExpired:
            return None, [], {}
        lines = [line.split() for line in counts.read_text().splitlines()] if counts.exists() else []
        files = contents(folder)
        shutil.rmtree(folder)
        counts.unlink(missing_ok=True)
        return done, lines, files

    def judge(self, arguments, whole, case):
        """One fault; what is wrong with the way it ended."""
        name, at, word, stays = case
        where = "%s-%d-%s%s" % (name, at, word, "-stays" if stays else "")
        done, lines, files = self.run(arguments, where, name, at, CODES[word], stays)
        wrong = []
        if done is None:
            wrong.append("it hangs")
        elif done.returncode not in (0, DEVICE):
            wrong.append("exit code %d: %s" % (done.returncode, done.stderr[-300:]))
        elif done.returncode == 0 and (files != whole or not HARMLESS.match(name)):
            wrong.append("exit code 0 with the files %s" % files)
        elif done.returncode == DEVICE and (files or word not in done.stderr):
            wrong.append("leaves %s and says: %s" % (sorted(files), done.stderr))
        left = {line[1]: int(line[2]) for line in lines if line[0] == "left"}
        if done is not None and not left:
            wrong.append("the layer saw no end")
        wrong += ["%d of %s left" % (count, kind) for kind, count in left.items()
                  if not 0 <= count <= KEPT.get(kind, 0)]
        return ["%s %s, call %d of %s with %s%s: %s" %
                (*arguments[:2], at, name, word, " and all that follow" if stays else "", text)
                for text in wrong]

    @staticmethod
    def cases(calls, every, all_codes):
        """Function, call, code, and whether all that follow fail, too."""
        words = list(CODES)
        cases = []
        for i, (name, count) in enumerate(calls.items()):
            ends = sorted({1, (count + 1) // 2, count} if every else {1, count})
            for at in range(1, count + 1) if every else ends:
                some = words if all_codes else [words[(i + at) % len(words)]]
                cases += [(name, at, word, False) for word in some]
            if every:
                cases += [(name, at, "CL_DEVICE_NOT_AVAILABLE", True) for at in ends]
        return cases

    def work(self, arguments, every, first):
        """All faults of one command."""
        self.run(arguments, "warm")  # compiles the programs
        done, lines, whole = self.run(arguments, "whole")
        calls = {line[1]: int(line[2]) for line in lines if line[0] == "call"}
        if done is not None and done.returncode == 0 and not lines:
            print("skipped: the OpenCL loader knows no layers")
            sys.exit(0)
        if done is None or done.returncode != 0 or not calls or not whole:
            sys.exit("%s without a fault: %s" % (arguments, done and done.stderr))
        cases = self.cases(calls, every, first)
        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            for wrong in pool.map(lambda case: self.judge(arguments, whole, case), cases):
                self.findings += wrong
        self.count += len(cases)
        print("%s: %d calls of %d functions, %d faults" %
              (" ".join(arguments[:4]), sum(calls.values()), len(calls), len(cases)), flush=True)


def main(program, layer, sources, folder, every=""):
    runs = Runs(program, layer, sources, folder)
    for arguments in WORK if every else WORK[:1]:
        runs.work(arguments, bool(every), bool(every) and arguments is WORK[0])
    print("\n".join(runs.findings[:40]))
    print("%d faults of OpenCL, %d findings" % (runs.count, len(runs.findings)))
    return 1 if runs.findings else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
