# SPDX-License-Identifier: Apache-2.0
"""Ten thousand renders in one process. Slow: about two minutes."""

import gc
import os

import numpy as np

RENDERS = 10_000
# By then the allocator's arenas have their size.
SETTLED = 1000


def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def test_memory_and_descriptors_stay_flat(rig):
    sums = set()
    for count in range(RENDERS):
        image = rig.render(spp=4, progress=False)
        sums.add(float(np.asarray(image).sum()))
        if count == SETTLED:
            gc.collect()
            before, open_before = resident(), len(os.listdir("/proc/self/fd"))
    gc.collect()
    # The allocator's own wandering is 0.7 MB; 220 bytes that each render left would be 2 MB.
    grown = resident() - before
    print("grown by %d bytes in %d renders" % (grown, RENDERS - SETTLED))
    assert grown < 2e6
    assert len(os.listdir("/proc/self/fd")) == open_before
    assert len(sums) == 1
