#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the targets of libFuzzer.

    run.py BUILD SECONDS [NAME...]   each target (or those named) for SECONDS

Inputs that reach new code are kept in BUILD/corpus/NAME for the next run. An input that crashes a
target, takes more than 10 s or more than 1 GB is left in BUILD/found; the exit code is then 1.
Seeds are the shipped scenes, the files of Khronos' validator in tests/strict, pictures of docs/, and
the files in ../shared/data where they are.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
LARGEST = 65536
TARGETS = ("scene", "set", "stl", "exr", "values", "text")
SETS = ("sensors/camera/fNumber=8", "nodes/0/translation=[0,0,1]", "emitters/0/radiance=2",
        "materials/0/reflectance=[0.1,0.2,0.3]", "nodes/0/scale=1e300", "sensors/0/resolution=4x4")
STL = (b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
       b"endloop\nendfacet\nendsolid a\n",
       b"\0" * 80 + b"\1\0\0\0" + b"\0" * 48 + b"\0\0")
TEXTS = (b"\0x,y,z,dx,dy,dz\n0,0,1,0,0,-1\n",
         b"\1MODE SEQ\nUNIT MM\nWAVM 1 0.55 1\nSURF 0\n  CURV 0\n  DISZ INFINITY\nSURF 1\n  STOP\n"
         b"  CURV 0.02\n  DISZ 5\n  GLAS N-BK7\n  DIAM 10\nSURF 2\n  CURV -0.02\n  DISZ 95\nSURF 3\n",
         b"\2LEN NEW\nDIM M\nWL 550\nSO 0 1e10\nS 50 5 BK7\nSTO\nS -50 95\nSI 0 0\nGO\n",
         b"\3%YAML:1.0\nimage_width: 640\nimage_height: 480\ncamera_matrix: !!opencv-matrix\n"
         b"   rows: 3\n   cols: 3\n   dt: d\n   data: [500,0,320,0,500,240,0,0,1]\n",
         b"\4ParGroup: Cam\n   Camera_type: area_scan_division\n", b'\5{"spp": 4, "set": ["a=1"]}')


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
        return files(*(s + "exr-*/*" for s in shared))
    if name == "values":
        return [b"\0" + picture for picture in files("docs/**/*.png")]
    if name == "text":
        lenses = [b"\1" + lens for s in shared for lens in files(s + "lens-prescriptions/*.zmx")]
        return [*TEXTS, *lenses, *(b"\5" + e for e in files("scenes/*.json"))]
    return STL if name == "stl" else [text.encode() for text in SETS]


def run(build, name, seconds):
    """Runs a target; True if it found nothing."""
    corpus, first, found = (build / part / name for part in ("corpus", "seeds", "found"))
    for folder in (corpus, first, found):
        folder.mkdir(parents=True, exist_ok=True)
    for i, seed in enumerate(seeds(name)):
        (first / ("%04d" % i)).write_bytes(seed)
    before = set(found.iterdir())
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [build / "tests/fuzz" / ("fuzz_" + name), "-max_total_time=%d" % seconds, "-timeout=10",
             "-rss_limit_mb=1024", "-max_len=%d" % LARGEST, "-print_final_stats=1",
             "-artifact_prefix=%s/" % found, corpus, first],
            cwd=folder, capture_output=True, text=True, errors="replace", check=False,
            env=dict(os.environ, ASAN_OPTIONS="allocator_may_return_null=1:detect_leaks=1"))
    count = re.search(r"number_of_executed_units:\s*(\d+)", done.stderr)
    cover = re.findall(r"cov: (\d+)", done.stderr)
    print("%-7s %9s inputs, %6s edges, %5d kept%s" %
          (name, count.group(1) if count else "?", cover[-1] if cover else "?",
           len(list(corpus.iterdir())), "" if done.returncode == 0 else ", FAILED"), flush=True)
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
