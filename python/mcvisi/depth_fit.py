# SPDX-License-Identifier: Apache-2.0
"""The fit of a depth to images of one texture; numpy is imported with it."""

from __future__ import annotations

import json
import operator
from typing import Any, Callable, Dict, List, Mapping, Sequence, Tuple

import numpy as np

from mcvisi.depths import Depth
from mcvisi.errors import BadInput, UsageError

CELLS = 64  # along the aperture's diameter
LEAST = 20  # power over noise of frequencies that count
FLAT = 0.75  # the window's share of each side that is even


def _is_square(number: Any, prime: int) -> Any:
    return np.isin(number % prime, [i * i % prime for i in range(1, prime)])


def _open_cells(attributes: Mapping[str, Any]) -> "np.ndarray[Any, Any]":
    """What the cells of the square about the aperture pass: rows upwards, columns to the right."""
    get: Callable[[str, Any], Any] = lambda key, other: attributes.get("mcvisi:" + key, other)
    middle = (np.arange(CELLS) + 0.5) / CELLS * 2 - 1
    x, y = np.meshgrid(middle, middle)
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    shape, turn = get("aperture", "disc"), float(get("apertureRotation", 0))
    passes: Any = np.ones_like(x)
    if shape == "ring":
        passes = radius > float(get("apertureRatio", 0.5))
    elif shape == "half":
        passes = np.cos(angle - turn) > 0
    elif shape == "blades":
        sector = 2 * np.pi / float(get("apertureBlades", 6))
        from_middle = np.mod(angle - turn, sector) - sector / 2
        passes = radius * np.cos(from_middle) < np.cos(sector / 2)
    elif shape == "coded":
        order = int(get("apertureOrder", 13))
        i = np.floor((1 + x * np.sqrt(2)) / 2 * order).astype(int)
        j = np.floor((1 - y * np.sqrt(2)) / 2 * order).astype(int)
        inside = (i > 0) & (i < order) & (j >= 0) & (j < order)
        passes = inside & ((j == 0) | (_is_square(i, order) == _is_square(j, order)))
    elif shape == "mask":
        numbers = [float(word) for word in get("apertureMask", "0").split()]
        side = int(numbers[0])
        cells = np.reshape(numbers[1:], (side, side))
        i = np.minimum((x + 1) / 2 * side, side - 1).astype(int)
        j = np.minimum((1 - y) / 2 * side, side - 1).astype(int)
        passes = cells[j, i]
    open_cells = np.where(radius < 1, passes, 0.0)
    return np.asarray(open_cells / open_cells.sum())


def _place(region: Any, shape: Tuple[int, ...]) -> Tuple[slice, slice]:
    """The region's rows and columns."""
    try:
        left, top, width, height = (operator.index(number) for number in region)
    except (TypeError, ValueError):
        left = top = width = height = -1
    if len(shape) != 2 or not (left >= 0 and top >= 0 and width >= 8 and height >= 8):
        raise UsageError(
            "depth: region must be X, Y, W, H of at least 8 x 8 pixels, of one channel"
        )
    if left + width > shape[1] or top + height > shape[0]:
        raise UsageError("depth: region reaches beyond the image")
    return slice(top, top + height), slice(left, left + width)


def _check_lens(header: Mapping[str, Any]) -> None:
    """Blur is of one size in the region only where the film stands straight behind its lens."""
    lens = json.loads(header.get("mcvisi:cameraModel", "{}")).get("lens", {})
    for key, value in lens.items():
        if key != "filmDistance" and value != 0:
            raise BadInput(
                "depth: an image's camera has %s %g, which changes the blur over the image: "
                "use a sensor without tilt and distortion" % (key, value)
            )


class _View:
    """One image's spectrum and noise, and the transfer function of its lens."""

    def __init__(self, image: Any, region: Tuple[int, int, int, int]) -> None:
        header = image.attributes
        for key in ("fNumber", "focalLength", "imageDistance", "pixelSize"):
            if "mcvisi:" + key not in header:
                raise BadInput("depth: an image's header has no %s: use a thinLens sensor" % key)
        if image.error is None:
            raise BadInput("depth: an image states no error: use what `camera` makes, as OpenEXR")
        _check_lens(header)
        values = np.asarray(image.array, float)
        cut = _place(region, values.shape)
        height, width = values[cut].shape
        window = np.outer(_window(height), _window(width))
        # Exposures differ: what counts is the texture over its mean.
        mean = np.average(values[cut], weights=window)
        variance = np.mean(np.asarray(image.error, float)[cut] ** 2)
        if not (mean > 0 and variance > 0):
            raise BadInput(
                "depth: an image has the mean %g and the noise %g in the region: both must be "
                "above 0, so light the region, and expose with noise" % (mean, variance**0.5)
            )
        values = values[cut] / mean - 1
        self.spread = height * width * np.sum(window**4) / np.sum(window**2) ** 2
        self.spectrum = np.fft.fft2(values * window)
        self.variance = variance / mean**2 * np.sum(window**2)
        self.columns, self.rows = np.fft.fftfreq(width), np.fft.fftfreq(height)
        self.distance = float(header["mcvisi:imageDistance"])
        # Of the image, whose pixels are several of the sensor's.
        pixel = np.ravel(header["mcvisi:pixelSize"]) * np.ravel(header.get("mcvisi:binning", 1))
        radius = self.distance / (2 * float(header["mcvisi:fNumber"]))
        self.reach = self.distance * radius / float(pixel[0]), self.distance * radius / float(
            pixel[-1]
        )
        self.focus = 1 / float(header["mcvisi:focalLength"]) - 1 / self.distance
        self.cells = _open_cells(header)

    def transfer(self, nearness: float) -> "np.ndarray[Any, Any]":
        """Of a texture at the depth 1/nearness: the place (x, y) of the aperture, in radii, sees
        it (1/w - 1/z) b r/p (x, -y) pixels aside."""
        middle = (np.arange(CELLS) + 0.5) / CELLS * 2 - 1
        aside = (self.focus - nearness) * np.asarray(self.reach)
        across = np.exp(-2j * np.pi * aside[0] * np.outer(self.columns, middle))
        down = np.exp(2j * np.pi * aside[1] * np.outer(self.rows, middle))
        return np.asarray(down @ self.cells @ across.T)


def _window(count: int) -> "np.ndarray[Any, Any]":
    """1 in the middle, and down to 0 as a cosine at both ends."""
    to_end = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5) / count
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(to_end / (0.5 - FLAT / 2), 1)))


def _misfit(views: Sequence[_View], nearness: float) -> float:
    """What no texture explains, over the noise: minus twice the logarithm of the likelihood."""
    powers = fitted = weights = 0.0
    for view in views:
        transfer = view.transfer(nearness)
        powers = powers + np.abs(view.spectrum) ** 2 / view.variance
        fitted = fitted + np.conj(transfer) * view.spectrum / view.variance
        weights = weights + np.abs(transfer) ** 2 / view.variance
    left = powers - np.abs(fitted) ** 2 / np.maximum(weights, 1e-300)
    return float(np.sum(left[_known(views)]))


def _known(views: Sequence[_View]) -> "np.ndarray[Any, Any]":
    """Frequencies whose light stands far above the noise: others would add their noise alone."""
    powers = sum(np.abs(view.spectrum) ** 2 / view.variance for view in views)
    return np.asarray(powers > LEAST * len(views))


def best_depth(
    images: Sequence[Any], region: Tuple[int, int, int, int], near: float, far: float
) -> Depth:
    """What mcvisi.depth says."""
    if len(images) < 2:
        raise UsageError("depth: one image tells no depth without its texture: give two or more")
    if not all(isinstance(end, (int, float, np.number)) for end in (near, far)):
        raise UsageError(
            "depth: near %r and far %r must be numbers, in metres: 0.25 for 25 cm" % (near, far)
        )
    if not 0 < near < far:
        raise UsageError("depth: near and far must be depths before the lens, 0 < near < far")
    views: List[_View] = [_View(image, region) for image in images]
    if any(abs(view.distance / views[0].distance - 1) > 1e-9 for view in views):
        raise UsageError(
            "depth: the images have several imageDistances, so that their scales differ"
        )
    pixels = max(max(view.reach) for view in views)  # that nearness moves the rim of the aperture
    steps = int(np.ceil((1 / near - 1 / far) * pixels * 4)) + 3
    tried = np.linspace(1 / far, 1 / near, steps)
    known: Dict[float, float] = {float(q): _misfit(views, float(q)) for q in tried}
    best = min(known, key=lambda q: known[q])
    step = float(tried[1] - tried[0])
    while step * pixels > 1e-4:
        step /= 2
        for q in (best - step, best + step):
            known.setdefault(q, _misfit(views, q))
        best = min((best - step, best, best + step), key=lambda q: known[q])
    step = 0.05 / pixels
    sides = [_misfit(views, best - step), known[best], _misfit(views, best + step)]
    bend = (sides[0] - 2 * sides[1] + sides[2]) / step**2
    if not bend > 0 or not 1 / far < best < 1 / near:
        raise BadInput("depth: no depth from near to far explains the images")
    # Each frequency of real images stands twice in the sum.
    nearness = float(np.sqrt(2 / bend * views[0].spread))
    free = np.count_nonzero(_known(views)) * (len(views) - 1)
    return Depth(1 / best, nearness / best**2, float(np.sqrt(sides[1] / free)))
