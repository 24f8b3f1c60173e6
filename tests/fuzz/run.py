#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the targets of libFuzzer.

    run.py BUILD SECONDS [NAME...]   each target (or those named) for SECONDS

Inputs that reach new code are kept in BUILD/corpus/NAME for the next run; BUILD/sums/NAME.json counts
inputs and processor seconds of all runs. An input that crashes a target, takes more than 10 s or more
than 1 GB is left in BUILD/found; the exit code is then 1.

Targets write their inputs as files into memory where the system has /dev/shm: a disk would take most
of the time. Seeds are the shipped scenes and experiments, the files of Khronos' validator in
tests/strict, those of openexr-images in tests/io, pictures of docs/, the files in ../shared/data where
they are, and small files of ours (seeds.py).
"""

import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile

import seeds as own

ROOT = pathlib.Path(__file__).resolve().parents[2]
LARGEST = 65536
MEMORY = pathlib.Path("/dev/shm")
TARGETS = ("scene", "set", "stl", "exr", "values", "text", "film", "matrix", "experiment", "table",
           "api")


def files(*patterns):
    """Small files of the sources, or beside them."""
    for pattern in patterns:
        for path in sorted(ROOT.glob(pattern)):
            if path.is_file() and 0 < path.stat().st_size <= LARGEST:
                yield path.read_bytes()


def seeds(name):
    shared = ("../shared/data/", "../../shared/data/")
    if name == "scene":
        return files("scenes/*.gl*", "tests/strict/khronos/**/*.gl*")
    if name == "exr":
        return files("tests/io/openexr-images/*/*")
    if name == "values":
        return [b"\0" + picture for picture in files("docs/**/*.png")]
    if name == "text":
        lenses = [b"\1" + lens for s in shared for lens in files(s + "lens-prescriptions/*.zmx")]
        return [*own.TEXTS, *lenses, *(b"\5" + e for e in files("scenes/*.json"))]
    if name == "experiment":
        return [*own.EXPERIMENTS, *own.experiments(ROOT)]
    if name == "film":
        return own.films(ROOT)
    return {"stl": own.STL, "set": own.SETS, "table": own.TABLES, "matrix": own.matrices(),
            "api": own.calls()}[name]


def spent():
    """Processor seconds of the targets that have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def add(path, inputs, seconds):
    """Adds a run to the sums of its target, and returns them."""
    sums = json.loads(path.read_text()) if path.exists() else {"inputs": 0, "seconds": 0}
    sums = {"inputs": sums["inputs"] + inputs, "seconds": sums["seconds"] + seconds}
    path.parent.mkdir(exist_ok=True)
    whole = path.with_suffix(".part")
    whole.write_text(json.dumps(sums))
    whole.replace(path)
    return sums


def run(build, name, seconds):
    """Runs a target; True if it found nothing."""
    corpus, first, found = (build / part / name for part in ("corpus", "seeds", "found"))
    for folder in (corpus, first, found):
        folder.mkdir(parents=True, exist_ok=True)
    for i, seed in enumerate(seeds(name)):
        (first / ("%04d" % i)).write_bytes(seed)
    before, begun = set(found.iterdir()), spent()
    with tempfile.TemporaryDirectory(dir=MEMORY if os.access(MEMORY, os.W_OK) else None) as folder:
        done = subprocess.run(
            [build / "tests/fuzz" / ("fuzz_" + name), "-max_total_time=%d" % seconds, "-timeout=10",
             "-rss_limit_mb=1024", "-max_len=%d" % LARGEST, "-print_final_stats=1",
             "-artifact_prefix=%s/" % found, corpus, first],
            cwd=folder, capture_output=True, text=True, errors="replace", check=False,
            env=dict(os.environ, ASAN_OPTIONS="allocator_may_return_null=1:detect_leaks=1",
                     LSAN_OPTIONS="print_suppressions=0:suppressions=%s" % (ROOT / "tests/lsan.supp")))
    count = re.search(r"number_of_executed_units:\s*(\d+)", done.stderr)
    sums = add(build / "sums" / (name + ".json"), int(count.group(1)) if count else 0, spent() - begun)
    cover = re.findall(r"cov: (\d+)", done.stderr)
    print("%-10s %9s inputs, %6s edges, %5d kept; in sum %d inputs, %.1f min%s" %
          (name, count.group(1) if count else "?", cover[-1] if cover else "?",
           len(list(corpus.iterdir())), sums["inputs"], sums["seconds"] / 60,
           "" if done.returncode == 0 else ", FAILED"), flush=True)
    if done.returncode == 0:
        return True
    print(done.stderr[-3000:])
    for path in sorted(set(found.iterdir()) - before):
        print("found: %s" % path)
    return False


def main(build, seconds, *names):
    for name in names:
        if name not in TARGETS:
            sys.exit("there is no target %s: %s" % (name, ", ".join(TARGETS)))
    results = [run(pathlib.Path(build).resolve(), name, int(seconds)) for name in names or TARGETS]
    return 0 if all(results) else 1


if __name__ == "__main__":
    if len(sys.argv) < 3 or not sys.argv[2].isdigit():
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
