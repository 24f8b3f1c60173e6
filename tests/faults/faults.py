#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails calls of memory and of files in the program, one at a time.

    faults.py PROGRAM FAULT.so SOURCES FOLDER [STEP [VERB...]]

Each run must end by itself: with exit code 0 where the call did not matter, or with another one and
a sentence. No file may be half written, and none but the outputs may stay. STEP: every STEP-th call
of memory and of write (by default each). VERB: these alone.
"""

import collections
import concurrent.futures
import csv
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import zipfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))
from same_bits import pixels_digest  # pylint: disable=wrong-import-position

CODES = (0, 1, 2, 3, 4)  # 2: a word of the options had no memory
TIMEOUT = 60  # an undisturbed run takes less than half a second
FILES = ("write", "fsync", "rename")
REFERENCE = ["--device", "reference"]
TINY = ["--resolution", "4x4", "--spp", "4"]
SCENE = "scenes/beam.gltf"
# What makes the inputs of the others.
INPUTS = (["render", SCENE, *REFERENCE, *TINY, "--parts", "replicates", "-o", "in.exr"],
          *(["render", SCENE, *REFERENCE, "--resolution", "4x4", "--samples", samples, "--film",
             "in-%d.film" % i, "-o", "part.exr"] for i, samples in enumerate(("0:4", "4:8"))),
          ["transport", "scenes/projector.gltf", *TINY, "-o", "in.npz"])
Work = collections.namedtuple("Work", "arguments kinds")
# OpenCL's drivers end the process where they have no memory: `own` leaves out what they ask for.
WORK = (
    Work(["check", SCENE], ("memory",)),
    Work(["check", "--json", SCENE], ("memory",)),
    Work(["check", "INPUTS/defects.gltf"], ("memory",)),
    Work(["check", "--strict", SCENE], ("memory",)),
    Work(["check", "--strict", "--json", SCENE], ("memory",)),
    Work(["render", SCENE, *REFERENCE, *TINY, "-o", "out.exr"], ("memory", *FILES)),
    Work(["render", SCENE, *TINY, "-o", "out.exr"], ("own", *FILES)),
    Work(["camera", "INPUTS/in.exr", "--expose-to", "0.6", "--full-well", "10000", "--read-noise", "5", "-o",
          "out.exr"],
         ("memory", *FILES)),
    Work(["merge", "INPUTS/in-0.film", "INPUTS/in-1.film", "-o", "out.exr"], ("memory", *FILES)),
    Work(["transport", "scenes/projector.gltf", *TINY, "-o", "out.npz"], ("own", *FILES)),
    Work(["relight", "INPUTS/in.npz", "-o", "out.exr"], ("memory", *FILES)),
    Work(["sweep", SCENE, *REFERENCE, *TINY, "--vary", "emitters/0/irradiance=1,2", "--region",
          "all=0,0,4,4", "--metric", "all.mean", "-o", "out.csv"], ("memory", *FILES)))


def with_defects(scene):
    """A scene whose panel has defects over one another, and whose camera looks at it by its name."""
    document = json.loads(scene.read_text())
    for node in document["nodes"]:
        if node["name"] == "camera":
            node["extensions"]["MCVISI_pose"]["target"] = "panel"
    defects = document["extensions"]["MCVISI_defects"]["defects"]
    one = {"node": defects[0]["node"], "size": "1mm", "depth": "5um", "count": 1}
    defects += [{**one, "type": "dent", "name": "many", "count": 2, "seed": 1},
                {"node": one["node"], "type": "stain", "name": "stain", "size": "1mm", "count": 1,
                 "material": document["materials"][0]["name"]},
                {**one, "type": "scratch", "name": "scratch", "length": "2mm", "at": [0.02, 0.015, 0]}]
    del defects[-1]["count"]
    return json.dumps(document)


def contents(path):
    """What must be the same in each run; None of a file that is not whole."""
    data = path.read_bytes()
    ends = {".png": b"IEND\xaeB`\x82", ".html": b"</html>\n"}
    try:
        if path.suffix == ".exr":
            return pixels_digest(path)
        if path.suffix == ".npz":
            with zipfile.ZipFile(path) as archive:
                return None if archive.testzip() else archive.read("data.npy")
        if path.suffix == ".json":
            return json.loads(data)
        if path.suffix == ".csv":  # all but the seconds
            rows = [row[:-2] + row[-1:] for row in csv.reader(io.StringIO(data.decode()))]
            return rows if data.endswith(b"\n") else None
        return True if data.endswith(ends[path.suffix]) else None
    except (ValueError, IndexError, KeyError, zipfile.BadZipFile):
        return None


def is_same(now, whole):
    """The same files; a row of a table may tell why its set failed."""
    if sorted(now) != sorted(whole):
        return False
    for name, rows in now.items():
        if not name.endswith(".csv"):
            if rows != whole[name]:
                return False
        elif len(rows) != len(whole[name]) or any(
                row != right and not row[-1] for row, right in zip(rows, whole[name])):
            return False
    return True


class Runs:
    def __init__(self, program, fault, sources, folder):
        self.program, self.fault = program, fault
        self.sources, self.folder = pathlib.Path(sources), pathlib.Path(folder)
        shutil.rmtree(folder, ignore_errors=True)
        self.inputs = self.folder / "inputs"
        self.inputs.mkdir(parents=True)
        self.count = 0
        (self.inputs / "defects.gltf").write_text(
            with_defects(self.sources / "scenes/painted-panel.gltf"))
        for arguments in INPUTS:
            subprocess.run(self.words(arguments), cwd=self.inputs, check=True,
                           stdout=subprocess.DEVNULL)

    def words(self, arguments):
        return [self.program, *(word.replace("INPUTS", str(self.inputs))
                                .replace("scenes/", str(self.sources) + "/scenes/")
                                for word in arguments)]

    def run(self, arguments, kind, at):
        """The ended process, how many calls there were, and the files."""
        folder = self.folder / ("%s-%d" % (kind, at))
        folder.mkdir()
        counted = self.folder / ("%s-%d.count" % (kind, at))
        environment = dict(os.environ, LD_PRELOAD=self.fault, MCV_FAULT=kind, MCV_FAULT_AT=str(at),
                           MCV_FAULT_COUNT=str(counted))
        try:
            done = subprocess.run(self.words(arguments), cwd=folder, env=environment, check=False,
                                  timeout=TIMEOUT, capture_output=True)
        except subprocess.TimeoutExpired:
            done = None
        calls = int(counted.read_text()) if counted.exists() else 0
        counted.unlink(missing_ok=True)
        files = {path.name: contents(path) for path in folder.iterdir()}
        shutil.rmtree(folder)
        return done, calls, files

    def judge(self, work, kind, at, whole):
        done, _, files = self.run(work.arguments, kind, at)
        wrong = ["leaves %s, which is not whole" % name for name, state in files.items()
                 if state is None or name not in whole]
        if done is None:
            wrong.append("it hangs")
        elif done.returncode not in CODES:
            wrong.append("exit code %d" % done.returncode)
        elif done.returncode != 0 and not done.stderr.strip():
            wrong.append("exit code %d without a sentence" % done.returncode)
        elif wrong:
            pass
        elif done.returncode == 0 and not is_same(files, whole) and not done.stderr.strip():
            wrong.append("exit code 0 with other %s" % sorted(files))
        return ["%s %d in mcvisi %s: %s" % (kind, at, " ".join(work.arguments), text)
                for text in wrong]

    def all(self, work, step):
        """What is wrong, of all kinds of fault of a command."""
        wrong = []
        for kind in work.kinds:
            done, calls, whole = self.run(work.arguments, kind, 0)
            if done is None or done.returncode != 0 or calls == 0 or None in whole.values():
                sys.exit("mcvisi %s without a fault: %s" % (" ".join(work.arguments), done))
            places = range(1, calls + 1, 1 if kind in ("fsync", "rename") else step)
            with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
                for found in pool.map(lambda at, kind=kind, whole=whole:
                                      self.judge(work, kind, at, whole), places):
                    wrong += found
            self.count += len(places)
            print("%-6s in mcvisi %s: %d calls, %d faults" %
                  (kind, " ".join(work.arguments[:4]), calls, len(places)), flush=True)
        return wrong


def main(program, fault, sources, folder, step=1, *verbs):
    runs = Runs(program, fault, sources, folder)
    wrong = [text for work in WORK if not verbs or work.arguments[0] in verbs
             for text in runs.all(work, int(step))]
    print("\n".join(wrong[:40]))
    print("%d faults, %d findings" % (runs.count, len(wrong)))
    return 1 if wrong or runs.count == 0 else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
