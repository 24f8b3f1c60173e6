# SPDX-License-Identifier: Apache-2.0
"""emd_peer.py PAIRS COLUMNS ROWS: writes the distances of pairs of histograms by POT, two doubles
each: normalized, mass.

PAIRS holds doubles: the first histogram of a pair, row by row, then the second.
"""

import math
import sys

import numpy
import ot


def main(path, columns, rows):
    bins = columns * rows
    pairs = numpy.fromfile(path).reshape(-1, 2, bins)
    places = [(i % columns / columns, i // columns / rows) for i in range(bins)]
    costs = numpy.array([[math.hypot(a[0] - b[0], a[1] - b[1]) for b in places] for a in places])
    # What is left of the larger mass goes to one more bin, which costs nothing.
    open_costs = numpy.zeros((bins + 1, bins + 1))
    open_costs[:bins, :bins] = costs
    for p, q in pairs:
        normalized = ot.emd2(p / p.sum(), q / q.sum(), costs, numItermax=10**7)
        surplus = p.sum() - q.sum()
        mass = ot.emd2(
            numpy.append(p, max(0, -surplus)),
            numpy.append(q, max(0, surplus)),
            open_costs,
            numItermax=10**7,
        )
        sys.stdout.buffer.write(
            numpy.array([normalized, mass + 0.5 * costs.max() * abs(surplus)]).tobytes()
        )


main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
