# SPDX-License-Identifier: Apache-2.0
"""Ten thousand renders in one process. Slow: about a minute."""

import json
import os
import subprocess
import sys

RENDERS = 10_000
# By then the allocator's arenas have their size.
SETTLED = 2000

SCRIPT = """
import gc, json, os
import mcvisi as mv, numpy as np

def state():
    gc.collect()
    with open("/proc/self/statm") as file:
        resident = int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return resident, len(os.listdir("/proc/self/fd"))

rig = mv.new("telecentric", "bracket.stl", unit="mm", resolution=(96, 64))
sums = set()
for count in range(%d):
    sums.add(float(np.asarray(rig.render(spp=4, progress=False)).sum()))
    if count == %d:
        before = state()
print(json.dumps([before, state(), len(sums)]))
"""


def test_memory_and_descriptors_stay_flat(folder):
    # With glibc's eight arenas per core the memory wanders by some MB: a render has a thread of its
    # own, which takes one of them. With two it wanders by 0.4 MB.
    environment = {**os.environ, "MALLOC_ARENA_MAX": "2"}
    command = [sys.executable, "-c", SCRIPT % (RENDERS, SETTLED)]
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    (before, open_before), (after, open_after), sums = json.loads(ended.stdout)
    print("grown by %d bytes in %d renders" % (after - before, RENDERS - SETTLED))
    # The texts and handles of a render are larger than 125 bytes: each that stayed would be 1 MB.
    assert after - before < 125 * (RENDERS - SETTLED)
    assert open_after == open_before
    # The same options, the same bits.
    assert sums == 1
