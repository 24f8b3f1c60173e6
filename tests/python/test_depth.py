# SPDX-License-Identifier: Apache-2.0
"""Depth of a flat texture from two apertures: its error is what the noise says."""

import base64
import struct
import zlib

import mcvisi as mv
import numpy as np
import pytest

SIDE = 256
FOCUS = 0.3


def _png(values):
    """A grey picture of 8 bits as a data URI."""
    rows = b"".join(b"\0" + row.tobytes() for row in values)
    chunks = [
        (b"IHDR", struct.pack(">IIBBBBB", len(values), len(values), 8, 0, 0, 0, 0)),
        (b"IDAT", zlib.compress(rows)),
        (b"IEND", b""),
    ]
    data = b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
        for name, body in chunks
    )
    return "data:image/png;base64," + base64.b64encode(data).decode()


def _rig(values, **lens):
    """A wall with this picture, and a camera at f/2 that sees 0.11 mm with a pixel."""
    camera = {"name": "camera", "type": "thinLens", "focalLength": "25mm", "fNumber": 2}
    camera.update(focusDistance=FOCUS, resolution=[96, 96], pixelSize="10um", **lens)
    camera.update(radiometry="irradiance")
    screen = {"name": "wall", "type": "telecentricProjector", "size": "40mm", "radiance": 1}
    screen.update(image="noise", halfAngle="30deg")
    sensor = {"MCVISI_sensors": {"sensor": 0}}
    emitter = {"MCVISI_emitters": {"emitter": 0}}
    return mv.Rig(
        {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": [0, 1]}],
            "extensionsUsed": ["MCVISI_emitters", "MCVISI_sensors"],
            "extensions": {
                "MCVISI_sensors": {"sensors": [camera]},
                "MCVISI_emitters": {"emitters": [screen]},
            },
            "images": [{"name": "noise", "uri": _png(values)}],
            "nodes": [
                {"name": "camera", "translation": [0, 0, FOCUS], "extensions": sensor},
                {"name": "wall", "rotation": [0, 1, 0, 0], "extensions": emitter},
            ],
        }
    )


@pytest.fixture(scope="module")
def wall():
    """Random cells of 0.16 mm, seen through a half."""
    cells = np.random.default_rng(1).integers(0, 256, (SIDE, SIDE), dtype=np.uint8)
    return _rig(cells, aperture="half", apertureRotation=0)


def _look(wall, depth, turn, seed, spp=64, exposure=0.2):
    wall["nodes/camera/translation"] = [0, 0, depth]
    wall["sensors/camera/apertureRotation"] = turn
    lit = wall.render(spp=spp, seed=seed, device="reference", progress=False)
    return lit.camera(expose_to=exposure, lens_mtf="none", seed=seed)


def test_two_halves(wall):
    """
    The errors of 8 depths over their uncertainty are normal numbers: all lie within 4, and their
    mean square within 0.07 and 4, which chi square of 8 leaves with probability 1e-4 on each
    side. Images that differ by noise alone have a misfit of 1; some 200
    frequencies count, which know it to 0.06.
    """
    errors = []
    for seed, depth in enumerate(np.repeat([0.295, 0.306], 4)):
        halves = [_look(wall, depth, turn, 2 * seed + k) for k, turn in enumerate((0, np.pi))]
        found = mv.depth(halves, (16, 16, 64, 64), near=0.25, far=0.36)
        errors.append((found.depth - depth) / found.uncertainty)
        assert found.misfit == pytest.approx(1, abs=0.3)
        assert 1e-5 < found.uncertainty < 2e-4
    print("errors over their uncertainty:", np.round(errors, 2))
    assert np.all(np.abs(errors) < 4)
    assert 0.07 < np.mean(np.square(errors)) < 4


def test_binned_pixels(wall):
    """
    Pixels of 2 x 2 of the sensor's see the same depth: a blur in the sensor's pixels would put it
    at half of its distance from the plane in focus, 3 mm or 80 uncertainties off. Of normal numbers
    all lie within four.
    """
    wall["sensors/camera/resolution"], wall["sensors/camera/binning"] = [192, 192], 2
    wall["sensors/camera/pixelSize"] = "5um"
    try:
        halves = [_look(wall, 0.306, turn, 40 + k) for k, turn in enumerate((0, np.pi))]
    finally:
        wall["sensors/camera/resolution"], wall["sensors/camera/binning"] = [96, 96], 1
        wall["sensors/camera/pixelSize"] = "10um"
    found = mv.depth(halves, (16, 16, 64, 64), near=0.25, far=0.36)
    assert abs(found.depth - 0.306) < 4 * found.uncertainty


@pytest.fixture(scope="module")
def discs():
    """Light through a wide and a narrow disc, 6 mm behind the focus."""
    cells = np.random.default_rng(1).integers(0, 256, (SIDE, SIDE), dtype=np.uint8)
    wall, lit = _rig(cells), []
    wall["nodes/camera/translation"] = [0, 0, 0.306]
    for k, number in enumerate((2, 5.6)):
        wall["sensors/camera/fNumber"] = number
        lit.append(wall.render(spp=256, seed=50 + k, device="reference", progress=False))
    return lit


def _exposed(lit, exposures, **camera):
    return [
        light.camera(expose_to=exposure, lens_mtf="none", seed=k, **camera)
        for k, (light, exposure) in enumerate(zip(lit, exposures))
    ]


@pytest.mark.parametrize(
    "camera",
    ({"black_level": 200}, {"dark_current": 2e5, "exposure_time": 0.01, "gain": 0.2}),
    ids=("black level", "dark current"),
)
def test_pedestal(discs, camera):
    """
    200 DN, and 2000 electrons, are no light. As such they would take contrast, most from the darker
    image: 200 DN would move the depth by 3 mm, some 50 uncertainties, and with 2000 electrons no
    depth would be found. Of normal numbers all lie within four.
    """
    seen = _exposed(discs, (0.2, 0.1), **camera)
    found = mv.depth(seen, (16, 16, 64, 64), near=0.301, far=0.33)
    print("error %.3g, u %.3g" % (found.depth - 0.306, found.uncertainty))
    assert abs(found.depth - 0.306) < 4 * found.uncertainty
    assert found.uncertainty < 1e-4


@pytest.mark.parametrize("gain, black", ((0.1, 0), (0.1, 30), (0.10004, 0)))
def test_full_well(discs, gain, black):
    """10000 electrons are 1000 DN at this gain, far below the 4095 of 12 bits, and rounded."""
    camera = {"full_well": 10000, "gain": gain, "black_level": black}
    region = (16, 16, 64, 64)
    mv.depth(_exposed(discs, (0.2, 0.2), **camera), region, near=0.301, far=0.33)
    seen = _exposed(discs, (0.9, 0.9), **camera)
    assert np.max(seen[0].array) == 1000 + black
    with pytest.raises(mv.BadInput, match="are saturated in an image"):
        mv.depth(seen, region, near=0.301, far=0.33)


@pytest.mark.parametrize("spoilt", (0, 1), ids=("wide", "narrow"))
def test_saturated_beside_the_region(discs, spoilt):
    """
    A pixel outside counts where the widest blur reaches the region: the narrow disc's image is
    blurred as the wide one's. With b = 1/(1/f - 1/w) = 27.3 mm, the image distance, the blur of f/2
    at 0.33 m has the radius (1/w - 1/z) b²/(2 N p) = 5.6 pixels, up to 6.
    """
    seen = _exposed(discs, (0.2, 0.2))
    image = seen[spoilt]

    def look(*places):
        values = np.array(image.array)
        for place in places:
            values[place] = 4095
        seen[spoilt] = mv.Image(values, image.error, image.attributes)
        return mv.depth(seen, (16, 16, 64, 64), near=0.301, far=0.33)

    for place in ((10, 40), (85, 40), (40, 10), (40, 85)):
        with pytest.raises(mv.BadInput, match="1 of 5776 pixels of the region, and of what blurs"):
            look(place)
    look((9, 40), (86, 40), (40, 9), (40, 86))


def test_what_does_not_fit(wall):
    half = _look(wall, FOCUS, 0, 1)
    with pytest.raises(mv.UsageError, match="give two or more"):
        mv.depth([half], (16, 16, 64, 64), 0.25, 0.36)
    with pytest.raises(mv.UsageError, match="beyond the image"):
        mv.depth([half, half], (64, 16, 64, 64), 0.25, 0.36)
    with pytest.raises(mv.UsageError, match="0 < near < far"):
        mv.depth([half, half], (16, 16, 64, 64), 0.36, 0.25)


def test_what_cannot_be_measured(wall):
    """A sentence of the package, in place of NaN and plain errors, and of a wrong depth."""
    half = _look(wall, FOCUS, 0, 1, spp=1)
    region = (16, 16, 64, 64)
    with pytest.raises(mv.UsageError, match="near '25cm' and far 0.36 must be numbers"):
        mv.depth([half, half], region, "25cm", 0.36)
    for wrong in ((16, 16, 64), "16,16,64,64", (16, 16, 64.5, 64), None):
        with pytest.raises(mv.UsageError, match="region must be X, Y, W, H"):
            mv.depth([half, half], wrong, 0.25, 0.36)
    with pytest.raises(mv.BadInput, match="are saturated in an image"):
        mv.depth([half, _look(wall, FOCUS, 0, 1, spp=1, exposure=0.9)], region, 0.25, 0.36)
    wall["emitters/wall/radiance"] = 0
    try:
        lit = wall.render(spp=1, device="reference", progress=False)
        dark = lit.camera(electrons_per_unit=1, noise_free=True)
        with pytest.raises(mv.BadInput, match="has the mean 0 above its dark level and"):
            mv.depth([half, dark], region, 0.25, 0.36)
    finally:
        wall["emitters/wall/radiance"] = 1
    for key, value in (("tilt", 0.05), ("k1", 0.1)):
        wall["sensors/camera/" + key] = value
        try:
            turned = _look(wall, FOCUS, 0, 1, spp=1)
        finally:
            wall["sensors/camera/" + key] = 0
        with pytest.raises(mv.BadInput, match="has %s %g" % (key, value)):
            mv.depth([turned, turned], region, 0.25, 0.36)
