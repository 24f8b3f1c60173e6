# SPDX-License-Identifier: Apache-2.0
"""Depth of a texture against its Cramér-Rao bound, by many exposures: halves and defocus."""

import mcvisi as mv
import numpy as np
import pytest
from test_depth import _rig

REGION = (16, 16, 64, 64)
# The brightest pixels have four times the mean: none is saturated. Some 3700 electrons per pixel.
CAMERA = {"expose_to": 0.2, "full_well": 25000}


@pytest.fixture(scope="module")
def texture():
    """What pixels resolve: noise blurred by 1.5 of them."""
    side, blur = 1024, 4.2
    noise = np.random.default_rng(1).normal(size=(side, side))
    f = np.fft.fftfreq(side)
    passed = np.exp(-2 * (np.pi * blur) ** 2 * (f[:, None] ** 2 + f**2))
    noise = np.fft.ifft2(np.fft.fft2(noise) * passed).real
    return np.clip(127.5 + 45 * noise / noise.std(), 0, 255).astype(np.uint8)


def _lit(wall, depth, seed, settings, scale=1, **options):
    """Light through each aperture; scale: of the texture."""
    wall["nodes/camera/translation"] = [0, 0, depth]
    wall["emitters/wall/size"] = 0.04 * scale
    options.update(progress=False)
    lit = []
    for k, setting in enumerate(settings):
        for key, value in setting.items():
            wall["sensors/camera/" + key] = value
        lit.append(wall.render(spp=1024, seed=seed + k, **options))
    return lit


HALVES = [{"apertureRotation": turn} for turn in (0, np.pi)]


def _trials(lit, depth, count, **camera):
    """Depths of so many exposures of the same light, and their uncertainties."""
    found = []
    for trial in range(count):
        seen = [
            light.camera(lens_mtf="none", seed=2 * trial + k, **camera)
            for k, light in enumerate(lit)
        ]
        found.append(mv.depth(seen, REGION, near=depth - 0.002, far=depth + 0.002)[:2])
    return np.transpose(found)


def test_halves_reach_the_bound(texture):
    """
    400 exposures know the standard deviation of the depths to 3.5 %. It is within 20 % of the
    Cramér-Rao bound that both images have if the texture is known, which mcvisi detect finds from
    renders: what shifts one way in one half and the other way in the other needs no knowledge of
    the texture. The region's soft border costs 5 %. The depths' mean is off by the error of the
    render, which all exposures share; it is below half an uncertainty here, so that 95 % of the
    depths, less four deviations of the binomial distribution, are within two.
    """
    depth, step, count = 0.301, 5e-4, 400
    camera = {"read_noise": 300, **CAMERA}
    wall = _rig(texture, aperture="half", apertureRotation=0)
    depths, u = _trials(_lit(wall, depth, 1, HALVES), depth, count, **camera)
    known = 0
    # The texture grows with its distance: its scale must not tell the depth.
    ends = [
        _lit(wall, z, 1, HALVES, z / depth, parts="replicates")
        for z in (depth - step / 2, depth + step / 2)
    ]
    for near, far in zip(*ends):
        told = far.detect(near, step=step, lens_mtf="none", within=REGION, **camera)
        known += told["bound"]["value"] ** -2
    bound, deviation = known**-0.5, np.std(depths, ddof=1)
    inside = np.count_nonzero(np.abs(depths - depth) < 2 * u)
    print(
        "deviation %.3g, bound %.3g: %.3f; mean error %.3g, stated %.3g; %d of %d within two"
        % (deviation, bound, deviation / bound, np.mean(depths) - depth, np.mean(u), inside, count)
    )
    assert deviation / bound < 1.2
    assert deviation / bound > 1 - 4 * np.sqrt(1 / (2 * count)) - 0.04
    assert abs(np.mean(depths) - depth) < np.mean(u) / 2
    assert inside > 0.95 * count - 4 * np.sqrt(count * 0.95 * 0.05)


def test_uncertainty_follows_the_noise(texture):
    """
    Read noise of 100 and 200 e- beside some 3700 photons. The render's error adds to both, and
    frequencies that drown in noise do not count: 6 %.
    """
    depth = 0.301
    wall = _rig(texture, aperture="half", apertureRotation=0)
    lit = _lit(wall, depth, 1, HALVES)
    once, twice = (
        _trials(lit, depth, 20, read_noise=noise, **CAMERA)[1] for noise in (100, 200)
    )
    ratio, truth = np.mean(twice) / np.mean(once), np.sqrt((200**2 + 3700) / (100**2 + 3700))
    print("ratio %.3f, must be %.3f" % (ratio, truth))
    assert ratio == pytest.approx(truth, rel=0.06)


def test_depth_from_defocus(texture):
    """
    A wide and a narrow disc, 4 mm behind the focus: only the blur tells the depth. The deviation of
    200 exposures is the stated uncertainty within four of its own, 1/√400 each, and what the
    render adds to the latter. The mean is off by the error of the render, which all exposures share:
    alone it makes an uncertainty of 0.1 % of the distance from the focus, four of which are 0.4 %.
    """
    depth, count = 0.304, 200
    lit = _lit(_rig(texture), depth, 1, [{"fNumber": n} for n in (2, 5.6)])
    depths, u = _trials(lit, depth, count, read_noise=300, **CAMERA)
    ratio, mean = np.std(depths, ddof=1) / np.mean(u), np.mean(depths) - depth
    print("deviation over stated %.3f, mean error %.3g, u %.3g" % (ratio, mean, np.mean(u)))
    assert ratio == pytest.approx(1, abs=4 / np.sqrt(2 * count))
    assert abs(mean) < 0.004 * (depth - 0.3) + 4 * np.mean(u) / np.sqrt(count)


@pytest.mark.parametrize("depth", (0.302, 0.306))
def test_no_bias(texture, depth):
    """
    With little noise: of a texture that pixels resolve the depth is right within four
    uncertainties and 0.2 % of the distance from the focus, to which the mask's cells are known.
    """
    wall = _rig(texture, aperture="half", apertureRotation=0)
    (found,), (u,) = _trials(_lit(wall, depth, 3, HALVES), depth, 1, **CAMERA)
    print("error %.3g, u %.3g" % (found - depth, u))
    assert abs(found - depth) < 4 * u + 0.002 * (depth - 0.3)
    assert u < 1e-5
