# SPDX-License-Identifier: Apache-2.0
"""sobol_peer.py VALUES PARAMETERS: first and total Sobol' indices by SALib, two doubles for each
parameter.

VALUES holds doubles, of each trial: A, A with each parameter of B, B.
"""

import sys

import numpy
from SALib.analyze import sobol


def main(path, parameters):
    problem = {
        "num_vars": parameters,
        "names": ["x%d" % i for i in range(parameters)],
        "bounds": [[0, 1]] * parameters,
    }
    found = sobol.analyze(problem, numpy.fromfile(path), calc_second_order=False, num_resamples=10)
    numpy.stack([found["S1"], found["ST"]], axis=1).astype(float).tofile(sys.stdout.buffer)


main(sys.argv[1], int(sys.argv[2]))
