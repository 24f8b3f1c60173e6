# SPDX-License-Identifier: Apache-2.0
"""The wheel's stand-in of LAPACKE computes what NumPy does."""

import ctypes
import pathlib
import subprocess

import mcvisi
import numpy as np
import pytest

SOURCE = pathlib.Path(__file__).resolve().parents[2] / "python" / "stand-ins" / "lapacke.c"
SIZE, STRIDE, COLUMNS = 40, 43, 7
ROWS, LOWER = 101, b"L"


@pytest.fixture(scope="module")
def lapacke(tmp_path_factory):
    target = tmp_path_factory.mktemp("stand-ins") / "lapacke.so"
    subprocess.run(["cc", "-shared", "-fPIC", "-O2", "-Wall", "-o", target, SOURCE], check=True)
    return ctypes.CDLL(str(target))


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def char(letter):
    return ctypes.c_char(letter)


def matrix():
    """Positive definite, its condition about 10: what differs are roundings, 40 or so of them."""
    numbers = np.random.default_rng(1).normal(size=(SIZE, 4 * SIZE))
    return numbers @ numbers.T / (4 * SIZE)


def padded(a):
    """In rows that are longer, and NaN above the diagonal: neither is touched."""
    b = np.full((SIZE, STRIDE), np.nan)
    b[:, :SIZE][np.tril_indices(SIZE)] = a[np.tril_indices(SIZE)]
    return b


def lower(b):
    assert np.isnan(b[:, SIZE:]).all() and np.isnan(b[:, :SIZE][np.triu_indices(SIZE, 1)]).all()
    return np.where(np.isnan(b), 0, b)[:, :SIZE]


def test_decomposition_and_inverse(lapacke):
    a = matrix()
    b = padded(a)
    assert lapacke.LAPACKE_dpotrf(ROWS, char(LOWER), SIZE, pointer(b), STRIDE) == 0
    assert np.allclose(lower(b), np.linalg.cholesky(a), rtol=0, atol=1e-13)
    assert lapacke.LAPACKE_dpotri(ROWS, char(LOWER), SIZE, pointer(b), STRIDE) == 0
    assert np.allclose(lower(b), np.tril(np.linalg.inv(a)), rtol=0, atol=1e-12)


def test_not_positive(lapacke):
    a = matrix()
    a[20, 20] = -1
    assert lapacke.LAPACKE_dpotrf(ROWS, char(LOWER), SIZE, pointer(padded(a)), STRIDE) == 21
    a[20, 20] = np.nan
    assert lapacke.LAPACKE_dpotrf(ROWS, char(LOWER), SIZE, pointer(padded(a)), STRIDE) == 21


@pytest.mark.parametrize("transposed", [b"N", b"T"])
def test_triangles(lapacke, transposed):
    triangle = np.linalg.cholesky(matrix())
    right = np.random.default_rng(2).normal(size=(SIZE, COLUMNS))
    a, b = padded(triangle), right.copy()
    call = [ROWS, char(LOWER), char(transposed), char(b"N"), SIZE, COLUMNS]
    call += [pointer(a), STRIDE, pointer(b), COLUMNS]
    assert lapacke.LAPACKE_dtrtrs(*call) == 0
    solved = triangle if transposed == b"N" else triangle.T
    assert np.allclose(b, np.linalg.solve(solved, right), rtol=0, atol=1e-12)
    a[3, 3] = 0
    assert lapacke.LAPACKE_dtrtrs(*call) == 4


@pytest.mark.parametrize("size", [1, 3, 12])
def test_eigenvectors(lapacke, size):
    """By columns: a row here is a column there. Their signs are free."""
    numbers = np.random.default_rng(size).normal(size=(size, size))
    whole = numbers + numbers.T
    a, values = np.full((size, size + 2), np.nan), np.zeros(size)
    a[:, :size][np.tril_indices(size)] = whole[np.tril_indices(size)]
    call = [102, char(b"V"), char(b"U"), size, pointer(a), size + 2, pointer(values)]
    assert lapacke.LAPACKE_dsyev(*call) == 0
    found, vectors = np.linalg.eigh(whole)
    # Some ten rotations of each row round numbers of the size of the largest value.
    assert np.allclose(values, found, rtol=0, atol=1e-14 * size * np.abs(found).max())
    assert np.allclose(np.abs((a[:, :size] * vectors.T).sum(axis=1)), 1, rtol=0, atol=1e-12)
    a[0, 0] = np.nan
    assert lapacke.LAPACKE_dsyev(*call) == 1
    assert lapacke.LAPACKE_dsyev(101, *call[1:]) < 0


@pytest.mark.parametrize("source, prefix", [("lapacke.c", "LAPACKE_"), ("cairo.c", "cairo_")])
def test_all_that_the_library_calls_is_there(source, prefix, tmp_path):
    """A wheel without one of them cannot be loaded."""

    def symbols(*options):
        listed = subprocess.run(["nm", "-D", *options], capture_output=True, text=True, check=True)
        names = {line.split()[-1].split("@")[0] for line in listed.stdout.splitlines()}
        return {name for name in names if name.startswith(prefix)}

    target = tmp_path / "stand-in.so"
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-o", target, SOURCE.parent / source, "-lm"], check=True
    )
    library = pathlib.Path(mcvisi.__file__).parent / "libmcvisi.so"
    wanted = symbols("--undefined-only", library)
    assert wanted and wanted <= symbols("--defined-only", target)


def test_what_is_not_there(lapacke):
    """Another order or triangle is refused, not computed wrongly."""
    b = padded(matrix())
    assert lapacke.LAPACKE_dpotrf(102, char(LOWER), SIZE, pointer(b), STRIDE) < 0
    assert lapacke.LAPACKE_dpotri(ROWS, char(b"U"), SIZE, pointer(b), STRIDE) < 0
