# SPDX-License-Identifier: Apache-2.0
"""emva1288_peer.py WIDTH: evaluates the images level-PHOTONS-N.bin (pairs) and half-PHOTONS-N.bin
(stacks) of the working folder.

By the reference implementation of EMVA 1288 (PyPI emva1288). Prints K, sigma_d, u_e.sat, DSNU1288,
PRNU1288 [%], QE [%], LE_min and LE_max [%]."""

import glob
import logging
import sys

import numpy

numpy.asfarray = lambda values: numpy.asarray(values, dtype=float)  # emva1288 1.0.2 knows NumPy 1

from emva1288.process.data import Data1288
from emva1288.process.loader import LoadImageData
from emva1288.process.results import Results1288


def load(path):
    return numpy.fromfile(path, dtype="<u2").reshape(-1, int(sys.argv[1])).astype("int64")


def main():
    images = {"temporal": {1.0: {}}, "spatial": {1.0: {}}}
    for path in sorted(glob.glob("level-*.bin")):
        images["temporal"][1.0].setdefault(float(path.split("-")[1]), []).append(path)
    for path in sorted(glob.glob("half-*.bin")):
        images["spatial"][1.0].setdefault(float(path.split("-")[1]), []).append(path)
    loaded = LoadImageData(images, fload=load, loglevel=logging.ERROR)
    found = Results1288(Data1288(loaded.data, loglevel=logging.ERROR).data, loglevel=logging.ERROR)
    numbers = [
        found.K,
        found.sigma_d,
        found.u_e_sat,
        found.DSNU1288,
        found.PRNU1288,
        found.QE,
        found.LE_min,
        found.LE_max,
    ]
    print(*(float(number) for number in numbers))


main()
