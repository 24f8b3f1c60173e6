# SPDX-License-Identifier: Apache-2.0
"""opencv_peer.py FILE...: shape, type, smallest, largest and sum of each image as OpenCV (of .npy:
NumPy) reads it."""

import sys

import cv2
import numpy

for path in sys.argv[1:]:
    image = numpy.load(path) if path.endswith(".npy") else cv2.imread(path, cv2.IMREAD_UNCHANGED)
    print(
        image.shape[1],
        image.shape[0],
        image.dtype,
        image.min(),
        image.max(),
        image.sum(dtype=numpy.int64),
    )
