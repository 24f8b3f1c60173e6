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

    region: X, Y, W, H in pixels, wider than the blur. BadInput for images without an error or light,
    with saturated pixels in the region, or of a camera without a lens, or with tilt or distortion;
    UsageError for what does not fit together.
    """
    from mcvisi.depth_fit import best_depth

    return best_depth(images, region, near, far)
