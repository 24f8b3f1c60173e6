# SPDX-License-Identifier: Apache-2.0
"""Light transport matrices: as SciPy sees them, and images of patterns."""

import json
import os
import pickle

import mcvisi as mv
import numpy as np
import pytest

sparse = pytest.importorskip("scipy.sparse")

SCENE = os.path.join(os.path.dirname(__file__), "../../scenes/gray-code.gltf")


@pytest.fixture(scope="module")
def transport(tmp_path_factory):
    path = tmp_path_factory.mktemp("transport")
    rig = mv.load(SCENE)
    made = rig.transport(
        spp=16, output=path / "matrix.npz", white=path / "white.exr", progress=False
    )
    made.folder = path
    return made


def test_product_is_the_image(transport):
    shown = transport.pattern[:, 0].astype(float)
    image = transport.relight()
    product = (transport.matrix @ shown).reshape(image.shape)
    # Both are sums in double; the image is rounded to float.
    assert np.all(np.abs(np.asarray(image) - product) <= 2.0**-23 * product)


def test_rows_add_up_to_white(transport):
    white = np.asarray(mv.read(transport.folder / "white.exr"))
    sums = np.asarray(transport.matrix.sum(axis=1)).reshape(white.shape)
    assert np.array_equal(sums.astype(np.float32), white)
    assert np.array_equal(np.asarray(transport.relight({"projector": 1})), white)


def test_error_is_that_of_the_replicates(transport):
    image, matrix = transport.relight(), transport.matrix
    shown = transport.pattern[:, 0].astype(float)
    by = []
    for k in range(transport.replicates.shape[1]):
        values = transport.replicates[:, k].astype(float)
        part = sparse.csr_array((values, matrix.indices, matrix.indptr), shape=matrix.shape)
        by.append(part @ shown)
    expected = np.std(by, axis=0, ddof=1).reshape(image.shape) / np.sqrt(len(by))
    # A difference of the size of the error: its rounding is that of the values.
    bound = 2.0**-22 * expected + 2.0**-50 * np.max(by)
    assert np.all(np.abs(np.asarray(image.error) - expected) <= bound)


def test_files(transport):
    path = transport.folder / "matrix.npz"
    loaded = sparse.load_npz(path)
    assert np.array_equal(loaded.toarray(), transport.matrix.toarray())
    file = np.load(path)
    header = json.loads(file["header.json"])
    assert header["width"] * header["height"] == loaded.shape[0]
    assert [group["emitter"] for group in header["elements"]] == ["projector"]
    assert np.array_equal(file["pattern"], transport.pattern)
    again = mv.Transport(path)
    assert np.array_equal(np.asarray(again.relight()), np.asarray(transport.relight()))
    again.save(transport.folder / "copy.npz")
    assert (transport.folder / "copy.npz").read_bytes() == path.read_bytes()


def test_pickle(transport):
    again = pickle.loads(pickle.dumps(transport))
    assert again.report == transport.report and again.header == transport.header
    assert np.array_equal(np.asarray(again.relight()), np.asarray(transport.relight()))


def test_arrays_outlive_the_handle():
    transport = mv.load(SCENE).transport(spp=4, progress=False)
    matrix = transport.matrix
    total = matrix.sum()
    del transport
    assert matrix.sum() == total > 0


@pytest.mark.parametrize(
    "pattern, error",
    [
        ({"sun": 1}, "there is no 'sun', but 'projector'"),
        ({"projector": np.ones((3, 3))}, "pattern: projector"),
        (np.ones(7), "must have the shape"),
        ({"projector": -1}, "must be finite and not negative"),
        ({"projector": np.nan}, "must be finite and not negative"),
    ],
)
def test_bad_patterns(transport, pattern, error):
    with pytest.raises(mv.Error, match=error):
        transport.relight(pattern)


def test_sequence(transport):
    images = transport.sequence({"type": "phaseShift", "steps": 4, "periods": 4}, "projector")
    assert len(images) == 4
    column = (np.arange(64) + 0.5) / 64
    for k, image in enumerate(images):
        shown = 0.5 + 0.5 * np.cos(2 * np.pi * (4 * column - k / 4))
        same = np.asarray(transport.relight({"projector": shown[None, :, None]}))
        # Both patterns are floats of one formula, computed twice.
        assert np.allclose(np.asarray(image), same, rtol=0, atol=2.0**-22 * same.max())
    with pytest.raises(mv.Error, match="type: is missing"):
        transport.sequence({})


def test_fit_is_nnls():
    """SciPy's active set finds the weights that ours finds."""
    optimize = pytest.importorskip("scipy.optimize")
    rig = mv.load(os.path.join(os.path.dirname(SCENE), "punctual.gltf"))
    made = rig.transport(spp=16, resolution="32x24", progress=False)
    image = made.fit("uniform", region="4,12,24,8")
    ours = [group["weight"]["value"] for group in image.report["weights"]]
    lamps = (made.matrix.toarray() * made.pattern.mean(axis=1)).reshape(24, 32, 3, -1)
    light = lamps.mean(axis=2)[12:20, 4:28].reshape(-1, lamps.shape[-1])
    target = np.full(len(light), light.sum(axis=1).mean())
    best, _ = optimize.nnls(light, target)
    # The descent ends at the root of the rounding; replicates are floats.
    assert np.allclose(ours, best, atol=1e-5 * best.max())
    assert image.report["figures"]["regions"][0]["uniformity"]["value"] > 0


def test_deflection(transport):
    scene = os.path.join(os.path.dirname(SCENE), "report-clean.glb")
    rig = mv.load(scene)
    rig["sensors/camera/regionOfInterest"] = [60, 55, 40, 10]
    made = rig.transport(spp=16, progress=False)
    image, histogram = made.deflection()
    assert image.shape == (10, 40, 2) and histogram.shape == (90, 360)
    shares = np.asarray(histogram).reshape(10, 9, 40, 9).sum(axis=(1, 3))
    assert np.allclose(shares, 1, atol=1e-5)
    # -h/f of the lens, in macro pixels of 180 um; bins are 2.2 mm of the lens at 300 mm.
    height = (np.arange(40) + 0.5 - 20) * 180e-6
    slope = np.polyfit(height, np.asarray(image)[:, :, 0].mean(axis=0), 1)[0]
    assert abs(slope + 1 / 0.3) < 0.05 / 0.3
    same, _ = made.deflection(made)
    assert np.array_equal(np.asarray(same), np.zeros((10, 40, 2)))
    with pytest.raises(mv.Error, match="the matrix has no directions"):
        transport.deflection()


def test_inverse_pattern(transport):
    """Least squares make the image of the pattern more even than white does."""
    pattern = transport.inverse_pattern("least-squares", bits=0)
    assert pattern.shape == (1, 64) and pattern.error.shape == (1, 64)
    assert np.asarray(pattern).max() == 1 and np.asarray(pattern).min() >= 0
    even = np.asarray(transport.relight({"projector": np.asarray(pattern)[:, :, None]}))
    white = np.asarray(transport.relight({"projector": 1}))
    lit = white > 0
    assert even[lit].std() / even[lit].mean() < white[lit].std() / white[lit].mean()
    dark = transport.inverse_pattern(field="dark")
    shown = transport.relight({"projector": np.asarray(dark)[:, :, None]})
    assert not np.asarray(shown).any()
    with pytest.raises(mv.Error, match="no emitter of this name with pixels"):
        transport.inverse_pattern(emitter="sun")
