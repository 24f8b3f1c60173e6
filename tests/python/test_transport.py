# SPDX-License-Identifier: Apache-2.0
"""Light transport matrices: as SciPy sees them, and images of patterns."""

import json
import os

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
