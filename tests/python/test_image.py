# SPDX-License-Identifier: Apache-2.0
"""Images: views without a copy, files, errors."""

import gc
import pickle

import mcvisi as mv
import numpy as np
import pytest


def test_a_view_without_a_copy(image):
    a, b = np.asarray(image), np.asarray(image)
    assert a.shape == (64, 96) and a.dtype == np.float32
    assert a.ctypes.data == b.ctypes.data == image.array.ctypes.data
    assert not a.flags.writeable and not a.flags.owndata
    with pytest.raises(ValueError):
        a[0, 0] = 1
    with pytest.raises(ValueError):
        a.flags.writeable = True
    assert np.asarray(image.error).shape == a.shape
    assert image.error.ctypes.data == image.error.ctypes.data
    assert image.samples is None


def test_the_view_keeps_the_picture(rig):
    image = rig.render(spp=16, progress=False)
    view, error = np.asarray(image), image.error
    before, error_before = view.copy(), error.copy()
    del image
    gc.collect()
    np.ones((512, 512))  # somebody else's memory
    assert np.array_equal(view, before) and np.array_equal(error, error_before)


def test_colour_has_its_channels_last():
    values = np.arange(2 * 3 * 3, dtype=np.float32).reshape(2, 3, 3)
    image = mv.Image(values, error=values / 10)
    view = np.asarray(image)
    assert image.shape == view.shape == (2, 3, 3)
    assert np.array_equal(view, values)
    assert np.array_equal(image.error, values / np.float32(10))
    # Planes in memory, a transposed view in numpy.
    assert view.strides == (12, 4, 24) and not view.flags.owndata


def test_values_by_index(image):
    values = np.asarray(image)
    assert image[3, 5] == values[3, 5] and np.array_equal(image[10:20, ::2], values[10:20, ::2])
    assert image[0].base is not None and not image[0].flags.writeable
    assert len(image) == 64 and image.dtype == np.float32
    assert np.array_equal(np.array([image, image]), np.array([values, values]))


def test_grey_values_from_numpy():
    values = np.random.default_rng(1).random((5, 7))
    assert np.array_equal(np.asarray(mv.Image(values)), values.astype(np.float32))
    # Any memory layout.
    assert np.array_equal(np.asarray(mv.Image(values.T[::-1])), values.T[::-1].astype(np.float32))
    assert np.asarray(mv.Image(values), dtype=float).dtype == float


@pytest.mark.parametrize(
    "values, error",
    [
        (np.zeros((2, 2, 2)), None),
        (np.zeros(5), None),
        (np.zeros((0, 4)), None),
        ("text", None),
        (np.ones((2, 2), complex), None),
        (None, None),
        ([[1, 2], [3]], None),
        (np.zeros((2, 2)), np.zeros((2, 3))),
    ],
)
def test_what_is_no_image(values, error):
    with pytest.raises(mv.UsageError):
        mv.Image(values, error=error)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_values_are_finite(wrong):
    values = np.ones((4, 4))
    values[1, 2] = wrong
    with pytest.raises(mv.BadInput):
        mv.Image(values)
    with pytest.raises(mv.BadInput):
        mv.Image(np.ones((4, 4)), error=-values)


def test_parts(rig):
    image = rig.render(spp=16, parts="replicates", progress=False)
    assert image.parts[:2] == ["image", "error"]
    replicates = [image.part("replicate %d" % i) for i in range(4)]
    assert np.allclose(np.mean(replicates, axis=0), image.array, rtol=1e-5, atol=1e-9)
    with pytest.raises(mv.UsageError, match="replicate 0"):
        image.part("none")


def test_what_an_image_knows(image):
    assert image.unit == "W/m^2"
    assert image.camera_model["model"] == "telecentric"
    assert image.report["samples"] == 16
    assert "96 x 64" in repr(image)


def test_exr_and_pickle_hold_all(image, tmp_path):
    image.save(tmp_path / "a.exr")
    for other in (mv.read(tmp_path / "a.exr"), pickle.loads(pickle.dumps(image))):
        assert np.array_equal(np.asarray(other), np.asarray(image))
        assert np.array_equal(other.error, image.error)
        assert other.camera_model == image.camera_model


def test_grey_values(image, tmp_path):
    grey = image.camera(expose_to=0.8, full_well=10_000, read_noise=5)
    assert grey.unit == "DN"
    values = np.asarray(grey)
    assert np.array_equal(values, np.round(values)) and 0 < values.max() <= 4095
    assert grey.report["full_well"] == 10_000
    for name in ("g.png", "g.tif", "g.npy"):
        grey.save(tmp_path / name)
    assert np.array_equal(np.load(tmp_path / "g.npy"), values)
    assert np.array_equal(np.asarray(mv.read(tmp_path / "g.png")), values)
    # The same seed, the same noise.
    again = image.camera(expose_to=0.8, full_well=10_000, read_noise=5)
    assert np.array_equal(np.asarray(again), values)
    other = image.camera(expose_to=0.8, full_well=10_000, read_noise=5, seed=1)
    assert not np.array_equal(np.asarray(other), values)


def test_options_of_one_or_three_values(image):
    one = image.camera(exposure_time="2ms", wavelength="630nm", noise_free=True)
    three = image.camera(exposure_time=2e-3, wavelength=[630e-9, "630nm", 0.63e-6], noise_free=True)
    assert np.array_equal(np.asarray(one), np.asarray(three))


def test_bad_options(image):
    with pytest.raises(mv.UsageError):
        image.camera(expose_to=object())
    with pytest.raises(mv.UsageError, match="finite"):
        image.camera(expose_to=float("nan"))
    with pytest.raises(mv.Error, match="bits"):
        image.camera(expose_to=0.8, bits=40)
    with pytest.raises(TypeError):
        image.camera(exposure=1)


def test_files_that_cannot_be(image, tmp_path):
    with pytest.raises(mv.Error):
        image.save(tmp_path / "none" / "a.exr")
    with pytest.raises(mv.Error):
        image.save(tmp_path / "a.jpg")
    with pytest.raises(mv.BadInput):
        mv.read(tmp_path / "none.exr")
    (tmp_path / "broken.exr").write_bytes(b"v/1\x01 nothing")
    with pytest.raises(mv.BadInput):
        mv.read(tmp_path / "broken.exr")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["broken.exr"]


def test_a_notebook_shows_it(image):
    assert image._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    grey = image.camera(expose_to=0.8, full_well=10_000)
    assert grey._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    wide = mv.Image(np.linspace(0, 1, 30 * 2600).reshape(30, 2600))
    shown = wide._repr_png_()
    assert int.from_bytes(shown[16:20], "big") == 2600 // 3


def test_compare(rig):
    a = rig.render(spp=64, parts="replicates", progress=False)
    b = rig.render(spp=64, parts="replicates", seed=1, progress=False)
    same = mv.compare(a, b)
    assert not same.different and "no difference" in same.reason
    assert np.asarray(same.difference).shape == (64, 96)
    rig["emitters/light/radiance"] = 2
    assert mv.compare(a, rig.render(spp=64, parts="replicates", seed=1, progress=False)).different
    with pytest.raises(mv.UsageError, match="Image"):
        mv.compare(a, np.asarray(b))
    with pytest.raises(mv.Error):
        mv.compare(a, mv.Image(np.zeros((3, 3)), error=np.ones((3, 3))))


def test_light_field(folder):
    rig = mv.new(
        "lightfield", folder / "bracket.stl", unit="mm", resolution=(24, 16), focal_length="25mm"
    )
    image = rig.render(spp=16, progress=False)
    rows, columns = image.shape[:2]
    assert image.views().shape[:2] == (rows, columns)
    gradient = image.emd_gradient(form="mass")
    assert gradient.shape[0] < rows


def test_detectability_of_a_difference(rig):
    without = rig.render(spp=16, parts="replicates", progress=False)
    same = without.detect(without, electrons_per_unit=1000)
    assert same["detectability"]["high"] == 0
    assert same["found_at_1_percent_false_calls"] == pytest.approx(0.01)
    assert same["values"] == without.array.size
    with pytest.raises(mv.UsageError, match="exactly once"):
        without.detect(without)
