# SPDX-License-Identifier: Apache-2.0
"""OpenCV and distortion: distortion_peer.py NAME...

NAME.yml is a camera as `--format opencv` writes it, NAME.txt has lines of a point of the world, and
of the place where the camera model sees it, in pixels from the image's corner.

cv2.projectPoints must find each place within 1e-6 pixels. cv2.undistortPoints must find the
point's direction, within what 1e-6 pixels are as a slope.
"""

import sys

import cv2
import numpy as np

STEPS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-14)


def compare(name):
    file = cv2.FileStorage(name + ".yml", cv2.FILE_STORAGE_READ)
    k, lens, rvec, tvec = (file.getNode(key).mat() for key in (
        "camera_matrix", "distortion_coefficients", "rvec", "tvec"))
    table = np.loadtxt(name + ".txt")
    points, places = table[:, :3].copy(), table[:, 3:] - 0.5
    seen = cv2.projectPoints(points, rvec, tvec, k, lens)[0][:, 0]
    there = np.abs(seen - places).max()
    slopes = cv2.undistortPoints(places[:, None].copy(), k, lens, criteria=STEPS)[:, 0]
    turned = points @ cv2.Rodrigues(rvec)[0].T + tvec.T
    back = np.abs((slopes - turned[:, :2] / turned[:, 2:]) * [k[0, 0], k[1, 1]]).max()
    print("%s: %d coefficients, %d points: %.2g pixels there, %.2g back"
          % (name, lens.size, len(table), there, back))
    return len(table) > 500 and there < 1e-6 and back < 1e-6


if __name__ == "__main__":
    sys.exit(0 if all([compare(name) for name in sys.argv[1:]]) else 1)
