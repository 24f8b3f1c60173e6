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
WITHIN = 8  # places along a cell's side, which tell how much of it is open
FINEST = 0.25  # cycles per pixel: pixels take finer ones for coarser ones that move the other way
LEAST = 4  # power over noise of frequencies that count
FLAT = 0.9  # the share of each side of the region that has its full weight
SOFT = 0.9  # and of the image


def _is_square(number: Any, prime: int) -> Any:
    return np.isin(number % prime, [i * i % prime for i in range(1, prime)])


def _open_cells(attributes: Mapping[str, Any]) -> "np.ndarray[Any, Any]":
    """What the cells of the square about the aperture pass: rows upwards, columns to the right."""
    get: Callable[[str, Any], Any] = lambda key, other: attributes.get("mcvisi:" + key, other)
    middle = (np.arange(CELLS * WITHIN) + 0.5) / (CELLS * WITHIN) * 2 - 1
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
    places = np.where(radius < 1, passes, 0.0)
    open_cells = places.reshape(CELLS, WITHIN, CELLS, WITHIN).sum((1, 3))
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


def _full(header: Mapping[str, Any]) -> float:
    """The grey value [DN] of a saturated pixel: the full well's, or the largest of its bits."""
    largest = 2.0 ** float(header.get("mcvisi:bits", np.inf)) - 1
    electrons = float(header.get("mcvisi:fullWell", np.inf))
    gain = float(header.get("mcvisi:gain", 1))
    well = float(header.get("mcvisi:blackLevel", 0)) + gain * electrons
    return float(min(largest, np.floor(well + 0.5)))  # as the camera rounds


def _pedestal(header: Mapping[str, Any]) -> float:
    """The mean grey value [DN] without light."""
    electrons = float(header.get("mcvisi:darkElectrons", 0))
    gain = float(header.get("mcvisi:gain", 1))
    return float(header.get("mcvisi:blackLevel", 0)) + gain * electrons


class _View:
    """One image about the region, its noise, and the transfer function of its lens."""

    def __init__(self, image: Any, region: Tuple[int, int, int, int]) -> None:
        header = image.attributes
        for key in ("fNumber", "focalLength", "imageDistance", "pixelSize"):
            if "mcvisi:" + key not in header:
                raise BadInput("depth: an image's header has no %s: use a thinLens sensor" % key)
        if image.error is None:
            raise BadInput("depth: an image states no error: use what `camera` makes, as OpenEXR")
        _check_lens(header)
        values = np.asarray(image.array, float)
        self.cut = _place(region, values.shape)
        self.saturated = values >= _full(header)
        # Exposures differ: what counts is the texture over its mean.
        values = values - _pedestal(header)
        mean = np.mean(values[self.cut])
        variance = np.mean(np.asarray(image.error, float)[self.cut] ** 2)
        if not (mean > 0 and variance > 0):
            raise BadInput(
                "depth: an image has the mean %g above its dark level and the noise %g in the "
                "region: both must be above 0, so light the region, and expose with noise"
                % (mean, variance**0.5)
            )
        self.values = values / mean - 1
        self.variance = variance / mean**2
        self.distance = float(header["mcvisi:imageDistance"])
        # Of the image, whose pixels are several of the sensor's.
        pixel = np.ravel(header["mcvisi:pixelSize"]) * np.ravel(header.get("mcvisi:binning", 1))
        radius = self.distance / (2 * float(header["mcvisi:fNumber"]))
        self.reach = self.distance * radius / float(pixel[0]), self.distance * radius / float(
            pixel[-1]
        )
        self.focus = 1 / float(header["mcvisi:focalLength"]) - 1 / self.distance
        self.cells = _open_cells(header)

    def transfer(self, nearness: float, shape: Tuple[int, int]) -> "np.ndarray[Any, Any]":
        """Of a texture at the depth 1/nearness, at the frequencies of an image of this shape: the
        place (x, y) of the aperture, in radii, sees it (1/w - 1/z) b r/p (x, -y) pixels aside."""
        middle = (np.arange(CELLS) + 0.5) / CELLS * 2 - 1
        aside = (self.focus - nearness) * np.asarray(self.reach)
        rows, columns = np.fft.fftfreq(shape[0]), np.fft.fftfreq(shape[1])
        across = np.exp(-2j * np.pi * aside[0] * np.outer(columns, middle))
        down = np.exp(2j * np.pi * aside[1] * np.outer(rows, middle))
        return np.asarray(down @ self.cells @ across.T)


def _check_exposure(views: Sequence[_View], nearnesses: Sequence[float]) -> None:
    """Saturated pixels take contrast from the sharper image, which then seems to be less sharp.
    Those beside the region count, too: each image is blurred as the others are at these depths."""
    right, down = (
        int(np.ceil(max(abs(v.focus - n) * v.reach[axis] for v in views for n in nearnesses)))
        for axis in (0, 1)
    )
    rows, columns = views[0].cut
    for view in views:
        about = view.saturated[
            max(rows.start - down, 0) : rows.stop + down,
            max(columns.start - right, 0) : columns.stop + right,
        ]
        count = int(np.count_nonzero(about))
        if count:
            raise BadInput(
                "depth: %d of %d pixels of the region, and of what blurs into it, are saturated in "
                "an image, which changes its blur: expose less, as by expose_to=0.2"
                % (count, about.size)
            )


def _window(count: int, flat: float) -> "np.ndarray[Any, Any]":
    """1 in the middle, and down to 0 as a cosine at both ends."""
    to_end = np.minimum(np.arange(count) + 0.5, count - np.arange(count) - 0.5) / count
    return np.asarray(0.5 - 0.5 * np.cos(np.pi * np.minimum(to_end / (0.5 - flat / 2), 1)))


def _windows(shape: Tuple[int, ...], flat: float) -> "np.ndarray[Any, Any]":
    return np.outer(_window(shape[0], flat), _window(shape[1], flat))


class _Fit:
    """
    How badly a depth explains the images. Each image, blurred as another one is, equals that other
    one blurred as the first is, whatever the texture. What differs is noise of a known spectrum:
    over it, and summed over all pairs, the squares are minus twice the logarithm of the likelihood
    with the texture that fits best. The images are blurred with what surrounds the region, so that
    its border changes nothing.
    """

    def __init__(self, views: Sequence[_View], shape: Tuple[int, ...]) -> None:
        self.views = views
        cut = views[0].cut
        self.region = _windows(tuple(c.stop - c.start for c in cut), FLAT)
        self.power = np.sum(self.region**2)
        self.spread = self.region.size * np.sum(self.region**4) / self.power**2
        # The images end softly at their own borders.
        self.whole = [np.fft.fft2(view.values * _windows(shape, SOFT)) for view in views]
        powers = sum(np.abs(self._spectrum(v.values)) ** 2 / v.variance for v in views)
        rows, columns = (np.abs(np.fft.fftfreq(side)) <= FINEST for side in self.region.shape)
        coarse = np.outer(rows, columns)
        self.known = coarse & (powers > LEAST * len(views) * self.power)

    def _spectrum(self, values: Any) -> Any:
        return np.fft.fft2(values[self.views[0].cut] * self.region)

    def misfit(self, nearness: float) -> float:
        """Minus twice the logarithm of the likelihood of a depth."""
        views, whole = self.views, self.whole
        blurs = [view.transfer(nearness, whole[0].shape) for view in views]
        own = [np.abs(view.transfer(nearness, self.region.shape)) ** 2 for view in views]
        weights = sum(o / view.variance for o, view in zip(own, views)) * self.power
        left: Any = 0.0
        for i in range(len(views)):
            for j in range(i):
                differs = np.fft.ifft2(blurs[j] * whole[i] - blurs[i] * whole[j]).real
                both = views[i].variance * views[j].variance
                left = left + np.abs(self._spectrum(differs)) ** 2 / both
        return float(np.sum((left / np.maximum(weights, 1e-300))[self.known]))


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
    shapes = {view.values.shape for view in views}
    if len(shapes) > 1:
        raise UsageError("depth: the images have several sizes")
    _check_exposure(views, (1 / near, 1 / far))
    fit = _Fit(views, shapes.pop())
    pixels = max(max(view.reach) for view in views)  # that nearness moves the rim of the aperture
    steps = int(np.ceil((1 / near - 1 / far) * pixels * 4)) + 3
    tried = np.linspace(1 / far, 1 / near, steps)
    known: Dict[float, float] = {float(q): fit.misfit(float(q)) for q in tried}
    best = min(known, key=lambda q: known[q])
    step = float(tried[1] - tried[0])
    while step * pixels > 1e-4:
        step /= 2
        for q in (best - step, best + step):
            known.setdefault(q, fit.misfit(q))
        best = min((best - step, best, best + step), key=lambda q: known[q])
    step = 0.05 / pixels
    sides = [fit.misfit(best - step), known[best], fit.misfit(best + step)]
    bend = (sides[0] - 2 * sides[1] + sides[2]) / step**2
    if not bend > 0 or not 1 / far < best < 1 / near:
        raise BadInput("depth: no depth from near to far explains the images")
    # Each frequency of real images stands twice in the sum.
    nearness = float(np.sqrt(2 / bend * fit.spread))
    free = np.count_nonzero(fit.known) * (len(views) - 1)
    return Depth(1 / best, nearness / best**2, float(np.sqrt(sides[1] / free)))
