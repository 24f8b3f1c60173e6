# SPDX-License-Identifier: Apache-2.0
"""Depth from images of one texture that differ in the camera's aperture."""

from __future__ import annotations

from typing import Any, NamedTuple, Sequence, Tuple


class Depth(NamedTuple):
    """A depth before the camera's lens, its standard uncertainty, and what the fit leaves."""

    depth: float
    uncertainty: float
    misfit: float


def depth(
    images: Sequence[Any], region: Tuple[int, int, int, int], near: float, far: float
) -> Depth:
    """
    The depth z [m] of a flat texture across the axis, from two images or more that differ in the
    camera's aperture: two halves, or apertures of other shapes or f-numbers, at one focus.

    The texture is not known. For each depth from near to far the blur of each image follows from
    its header, by geometrical optics; the depth is the one at which one texture explains all images
    best (maximum likelihood, in frequencies of the region that stand above the noise). The
    uncertainty is that of the noise that the images state, for small errors. misfit is 1 where
    images differ by noise alone.

    Discs, and other apertures that half a turn leaves as they are, cannot tell the side of the
    focus: near and far must lie on one side of it, or the depth may be the mirrored one.

    region: X, Y, W, H in pixels, wider than the blur. Black level and dark electrons of the header
    are no light. BadInput for images without an error or light, with pixels at the full well or the
    largest grey value in the region or in what blurs into it from near to far, or of a camera
    without a lens, or with tilt or distortion; UsageError for what does not fit together.
    """
    from mcvisi.depth_fit import best_depth

    return best_depth(images, region, near, far)
