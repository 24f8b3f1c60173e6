#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails calls of memory and of files in the program, one at a time.

    faults.py PROGRAM FAULT.so SOURCES FOLDER [STEP]

Each run must end by itself: with exit code 0 where the call did not matter, or with another one and
a sentence. No output may be half written, and none but the output may stay. STEP: every STEP-th call
of memory (by default each).
"""

import os
import pathlib
import subprocess
import sys

CODES = (0, 1, 2, 3, 4)  # 2: a word of the options had no memory


def main(program, fault, sources, folder, step=1):
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    scene = str(pathlib.Path(sources) / "scenes/beam.gltf")
    render = ["render", scene, "--device", "reference", "--resolution", "4x4", "--spp", "4", "-o",
              "out.exr"]
    # Not yet check --strict: it reads its report again, and where jansson's parser has no memory
    # for a string of it, the program crashes later.
    work = [("memory", int(step), ["check", scene]),
            ("write", 1, render), ("fsync", 1, render), ("rename", 1, render)]
    failures, runs = [], 0

    def run(arguments, kind, at):
        for path in folder.iterdir():
            path.unlink()
        environment = dict(os.environ, LD_PRELOAD=fault, MCV_FAULT=kind, MCV_FAULT_AT=str(at),
                           MCV_FAULT_COUNT=str(folder / "count"))
        done = subprocess.run([program, *arguments], cwd=folder, env=environment, timeout=60,
                              capture_output=True, check=False)
        count = folder / "count"
        calls = int(count.read_text()) if count.exists() else 0
        count.unlink(missing_ok=True)
        return done, calls

    for kind, every, arguments in work:
        whole, calls = run(arguments, kind, 0)
        files = {path.name: path.stat().st_size for path in folder.iterdir()}
        if whole.returncode != 0 or calls == 0:
            failures.append("%s %s: %d calls, exit code %d" %
                            (kind, arguments[0], calls, whole.returncode))
        for at in range(1, calls + 1, every):
            done, _ = run(arguments, kind, at)
            runs += 1
            where = "%s %d of %d in mcvisi %s" % (kind, at, calls, " ".join(arguments))
            if done.returncode not in CODES:
                failures.append("%s: exit code %d" % (where, done.returncode))
            elif done.returncode != 0 and not done.stderr.strip():
                failures.append("%s: exit code %d without a sentence" % (where, done.returncode))
            for path in folder.iterdir():
                if path.name not in files or path.stat().st_size != files[path.name]:
                    failures.append("%s: leaves %s of %d bytes" %
                                    (where, path.name, path.stat().st_size))
        print("%s in mcvisi %s: %d calls" % (kind, " ".join(arguments[:2]), calls))
    print("\n".join(failures[:20]))
    print("%d faults, %d findings" % (runs, len(failures)))
    return 1 if failures or runs == 0 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
