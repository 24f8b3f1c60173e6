# SPDX-License-Identifier: Apache-2.0
"""Laser triangulation: the heights of a bracket whose thickness is known."""

import mcvisi as mv
import numpy as np
import pytest
from mcvisi import examples

COLUMNS, ROWS = 64, 48
TOP = examples.BOXES[0][1][2] * 1e-3
LOWER = 1e-3


@pytest.fixture(scope="module")
def head(folder):
    """A head whose camera stands aside of the laser, before the bracket's large face."""
    return mv.new(
        "laser", folder / "bracket.stl", unit="mm", f_number=1.4, resolution=(COLUMNS, ROWS)
    )


@pytest.fixture(scope="module")
def images(head):
    """Grey values of the bracket as it is, and LOWER further away from the laser."""
    found = []
    for lower in (0, LOWER):
        head["nodes/part/translation"] = [0, 0, -lower]
        lit = head.render(spp=64, device="reference", progress=False)
        found.append(lit.camera(expose_to=0.5, wavelength="660nm"))
    return found


def test_heights(images):
    """
    In the bracket's own coordinates its face is at TOP, wherever it is, between LEFT and RIGHT. Of
    100 normal errors none passes 5 deviations, nor do both means. A window of 15 pixels holds 7
    deviations of the line on both sides, so that the place itself has no error that counts.
    """
    found = mv.triangulate(images, "laser", frame="part")
    assert found.shape == found.error.shape == (2, COLUMNS) and found.unit == "m"
    assert found.parts == ["image", "error", "x", "y", "place", "mask"]
    seen = found.part("mask") == 1
    assert np.array_equal(seen, np.isfinite(found.array)) and found.report["seen"] == seen.sum()
    # The columns within a width are known to one, and a column at either end is lit in part.
    step = np.nanmean(np.diff(found.part("x")))
    assert np.all(np.abs(seen.sum(axis=1) - examples.WIDTH * 1e-3 / step) < 2)
    for heights, error, there in zip(found.array, found.error, seen):
        off, u = heights[there] - TOP, error[there]
        assert np.all(np.abs(off) < 5 * u)
        assert abs(off.mean()) < 5 * np.sqrt(np.mean(u**2) / len(u))


def test_the_laser_s_own_coordinates(images):
    """The second image is LOWER below the first, and lies a feed behind it."""
    found = mv.triangulate(images, "laser", feed="0.2mm")
    seen = np.all(np.isfinite(found.array), axis=0)
    (first, second), u = found.array[:, seen].mean(axis=1), found.error[:, seen]
    assert abs(first - second - LOWER) < 5 * np.sqrt(np.sum(u**2)) / seen.sum()
    behind = np.diff(found.part("y"), axis=0)[0, seen]
    assert behind == pytest.approx(-0.2e-3, rel=1e-6)


def test_files(images, tmp_path):
    """An image of a file is that of memory, and the files have the same numbers."""
    images[0].save(tmp_path / "grey.exr")
    files = [tmp_path / "z.csv", tmp_path / "z.npz"]
    found = mv.triangulate(tmp_path / "grey.exr", "laser", output=files)
    again = mv.triangulate(images[0], "laser", output=tmp_path / "z.exr")
    read = mv.read(tmp_path / "z.exr")
    for part in found.parts:
        assert np.array_equal(found.part(part), again.part(part), equal_nan=True)
        assert np.array_equal(found.part(part), read.part(part), equal_nan=True)
    heights = np.load(tmp_path / "z.npz")["z"].astype(np.float32)
    assert np.array_equal(heights, found.array, equal_nan=True)
    assert len(files[0].read_text().splitlines()) == 1 + COLUMNS
    # Views of the library's memory.
    views = [np.asarray(found) for _ in range(2)]
    assert views[0].ctypes.data == views[1].ctypes.data and not views[0].flags.writeable


def test_refused(images, tmp_path):
    grey = images[0]
    for given, options, sentence in (
        ([], {}, "there are no images"),
        (5, {}, "images: must be a file name, not int"),
        (grey, {"window": 4}, "must be odd"),
        (grey, {"extractor": "best"}, "extractor"),
        (grey, {"output": tmp_path / "z.txt"}, "must end in .csv, .exr, .npz, .npy or .ply"),
        (images, {}, "give feed D, or frame NODE"),
    ):
        with pytest.raises(mv.UsageError, match=sentence):
            mv.triangulate(given, "laser", **options)
    with pytest.raises(mv.Error, match="lasr"):
        mv.triangulate(grey, "lasr")
    with pytest.raises(mv.BadInput, match="none.exr"):
        mv.triangulate([grey, tmp_path / "none.exr"], "laser")
    with pytest.raises(TypeError, match="laser"):
        mv.triangulate(grey)
    assert not list(tmp_path.iterdir())


def test_scan(head):
    """The face at TOP again, of a head that has moved by half a millimetre between two profiles."""
    head["nodes/part/translation"] = [0, 0, 0]
    shape = (2, COLUMNS // 2)
    head["sensors/camera/resolution"] = [COLUMNS // 2, ROWS // 2]
    quiet = {"device": "reference", "progress": False}
    options = {"frame": "part", "expose_to": 0.2, **quiet}
    found = head.scan(profiles=2, feed="0.5mm", **options)
    assert found.shape == found.error.shape == shape and found.unit == "m"
    there = np.isfinite(found.array)
    off, u = (found.array - TOP)[there], found.error[there]
    assert abs(off.mean()) < 5 * np.sqrt(np.mean(u**2) / len(u))
    assert found.report["head"]["points_per_profile"] == shape[1]
    single = head.scan(profiles=1, budget=True, **options)
    assert single.shape == (1, shape[1]) and single.report["budget"]["speckle"] > 0
    # What the sensor says needs no options, and is the same.
    head["sensors/camera/type"] = "laserTriangulation"
    for key, value in (("frame", "part"), ("profiles", 2), ("feed", "0.5mm"), ("exposeTo", 0.2)):
        head["sensors/camera/" + key] = value
    keys = head.scan(**quiet)
    assert np.array_equal(keys.array, found.array, equal_nan=True)
