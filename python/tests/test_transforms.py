"""`points2alm` and `alm2points`: against the definition, healpy, ducc0 and scipy, and at the edges."""

import threading

import ducc0
import healpy
import numpy as np
import pytest
import scipy.special
from hypothesis import given, settings
from hypothesis import strategies as st

import sphvar


def random_points(n, seed=0):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1)[:, np.newaxis]


def random_alm(lmax, seed=0):
    rng = np.random.default_rng(seed)
    size = (lmax + 1) * (lmax + 2) // 2
    alm = rng.normal(size=size) + 1j * rng.normal(size=size)
    alm[: lmax + 1].imag = 0
    return alm


def angles(points):
    theta = np.arctan2(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
    return theta, np.arctan2(points[:, 1], points[:, 0]) % (2 * np.pi)


def harmonics(points, lmax):
    """Y_lm at the points, in the order of healpy."""
    theta, phi = angles(points)
    pairs = [(l, m) for m in range(lmax + 1) for l in range(m, lmax + 1)]
    return np.array([scipy.special.sph_harm_y(l, m, theta, phi) for l, m in pairs])


METHODS = ["auto", "exact", "fast"]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("n", "lmax"), [(1, 0), (1, 7), (50, 12), (300, 5), (40, 33)])
def test_sums_are_those_of_the_definition(n, lmax, method):
    points = random_points(n)
    weights = np.random.default_rng(1).normal(size=n)
    y = harmonics(points, lmax)
    for w in [None, weights]:
        alm = sphvar.points2alm(points, lmax, weights=w, method=method)
        expected = y.conj() @ (np.ones(n) if w is None else w)
        scale = np.linalg.norm(np.abs(y) @ np.abs(np.ones(n) if w is None else w))
        assert alm.dtype == np.complex128
        assert np.linalg.norm(alm - expected) < 2e-12 * scale
    alm = random_alm(lmax)
    twice = np.where(np.arange(len(alm)) <= lmax, 1, 2)
    expected = ((alm * twice)[:, np.newaxis] * y).real.sum(axis=0)
    values = sphvar.alm2points(alm, points, method=method)
    assert values.dtype == np.float64
    bound = (lmax + 1) / np.sqrt(4 * np.pi) * np.linalg.norm(np.sqrt(twice) * alm)
    assert np.abs(values - expected).max() < 1e-12 * bound


@pytest.mark.parametrize(("n", "lmax"), [(1, 0), (200, 20), (1000, 64)])
def test_transforms_are_adjoint(n, lmax):
    points, alm = random_points(n), random_alm(lmax)
    weights = np.random.default_rng(2).normal(size=n)
    adjoint = sphvar.points2alm(points, lmax, weights=weights)
    twice = np.where(np.arange(len(alm)) <= lmax, 1, 2)
    by_degrees = (twice * alm * adjoint.conj()).real.sum()
    by_points = weights @ sphvar.alm2points(alm, points)
    assert by_degrees == pytest.approx(by_points, rel=1e-11, abs=1e-11 * n)


@pytest.mark.parametrize("method", ["auto", "exact", "fast"])
def test_healpy_agrees(method):
    nside, lmax = 8, 16
    alm = random_alm(lmax)
    pixels = np.array(healpy.pix2vec(nside, np.arange(12 * nside**2))).T
    values = sphvar.alm2points(alm, pixels, method=method)
    expected = healpy.alm2map(alm, nside)
    assert np.abs(values - expected).max() < 1e-11 * np.abs(expected).max()
    # Without weights of rings and iterations, map2alm is the adjoint times the area of a pixel.
    expected = healpy.map2alm(values, lmax=lmax, iter=0)
    got = sphvar.points2alm(pixels, lmax, weights=values * 4 * np.pi / len(pixels), method=method)
    assert np.abs(got - expected).max() < 1e-11 * np.abs(expected).max()
    assert len(got) == healpy.Alm.getsize(lmax)


@pytest.mark.parametrize(("n", "lmax"), [(100, 3), (2000, 100), (20000, 300)])
def test_ducc_agrees(n, lmax):
    points, alm = random_points(n), random_alm(lmax)
    loc = np.array(angles(points)).T
    options = dict(loc=loc, spin=0, lmax=lmax, epsilon=1e-12)
    expected = ducc0.sht.synthesis_general(alm=alm[np.newaxis], **options)[0]
    values = sphvar.alm2points(alm, points)
    assert np.abs(values - expected).max() < 1e-10 * np.abs(expected).max()
    expected = ducc0.sht.adjoint_synthesis_general(map=values[np.newaxis], **options)[0]
    got = sphvar.points2alm(points, lmax, weights=values)
    assert np.linalg.norm(got - expected) < 1e-10 * np.linalg.norm(expected)


@pytest.mark.parametrize("method", METHODS)
def test_batches_have_the_bits_of_single_sets(method):
    sets = random_points(9 * 40).reshape(9, 40, 3)
    weights = np.random.default_rng(3).normal(size=(9, 40))
    alms = sphvar.points2alm(sets, 20, weights=weights, method=method)
    assert alms.shape == (9, 231)
    for one, w, points in zip(alms, weights, sets, strict=True):
        assert np.array_equal(one, sphvar.points2alm(points, 20, weights=w, method=method))
    shared = sphvar.points2alm(sets, 20, weights=weights[0], method=method)
    assert np.array_equal(shared[0], alms[0])
    assert sphvar.points2alm(sets[:0], 20).shape == (0, 231)


def test_many_large_sets_have_the_bits_of_single_sets():
    sets = random_points(6 * 20000).reshape(6, 20000, 3)
    alms = sphvar.points2alm(sets, 100)
    assert np.array_equal(alms[5], sphvar.points2alm(sets[5], 100))


def test_values_have_the_shape_of_the_points():
    alm, points = random_alm(6), random_points(24)
    flat = sphvar.alm2points(alm, points)
    assert np.array_equal(sphvar.alm2points(alm, points.reshape(2, 3, 4, 3)).ravel(), flat)
    assert sphvar.alm2points(alm, np.zeros((0, 3))).shape == (0,)
    assert sphvar.points2alm(np.zeros((0, 3)), 2).tolist() == [0] * 6


def test_poles_and_repeated_points():
    points = np.array([[0, 0, 1.0], [0, 0, -1], [0, 0, 1], [1, 0, 0], [1, 0, 0]])
    y = harmonics(points, 9)
    for method in METHODS:
        alm = sphvar.points2alm(points, 9, method=method)
        assert np.abs(alm - y.conj().sum(axis=1)).max() < 1e-11
        values = sphvar.alm2points(alm, points, method=method)
        assert values[0] == values[2] and values[3] == values[4]


def test_layouts_and_types():
    points = random_points(30)
    expected = sphvar.points2alm(points, 8)
    strided = np.zeros((60, 6))
    strided[::2, ::2] = points
    fixed = points.copy()
    fixed.flags.writeable = False
    unaligned = np.frombuffer(b"x" + points.tobytes(), dtype=np.uint8)[1:].view(np.float64)
    for same in [
        np.asfortranarray(points),
        strided[::2, ::2],
        points[::-1][::-1],
        fixed,
        points.astype(">f8"),
        unaligned.reshape(30, 3),
        points.tolist(),
        points.astype(object).tolist(),
    ]:
        assert np.array_equal(sphvar.points2alm(same, 8), expected)
    single = sphvar.points2alm(points.astype(np.float32), 8)
    assert 0 < np.abs(single - expected).max() < 1e-4
    alm = random_alm(8)
    assert np.array_equal(
        sphvar.alm2points(alm[::-1].copy()[::-1], fixed), sphvar.alm2points(alm, points)
    )
    assert sphvar.alm2points(alm.astype(np.complex64), points).dtype == np.float64
    real = np.zeros(45)
    real[0] = np.sqrt(4 * np.pi)
    assert np.allclose(sphvar.alm2points(real, points), 1)


def test_lmax_is_that_of_the_coefficients():
    alm, points = random_alm(7), random_points(5)
    assert np.array_equal(sphvar.alm2points(alm, points, lmax=7), sphvar.alm2points(alm, points))
    with pytest.raises(ValueError, match="lmax = 6 requires 28"):
        sphvar.alm2points(alm, points, lmax=6)
    with pytest.raises(ValueError, match=r"as 1, 3, 6 or 10, got 35"):
        sphvar.alm2points(alm[:-1], points)
    alm[3] += 2j
    without = alm.copy()
    without[3] = without[3].real
    assert np.array_equal(sphvar.alm2points(alm, points), sphvar.alm2points(without, points))


@given(st.integers(0, 400))
@settings(deadline=None, max_examples=40)
def test_every_degree_is_found(lmax):
    alm = np.zeros((lmax + 1) * (lmax + 2) // 2)
    alm[0] = 1
    assert sphvar.alm2points(alm, [[0, 0, 1]], method="exact")[0] == pytest.approx(0.2820947917738781)


@pytest.mark.parametrize(
    ("change", "kind", "message"),
    [
        (dict(points=np.zeros((4, 2))), ValueError, r"points: expected shape \(n, 3\)"),
        (dict(points=np.zeros(3)), ValueError, r"got \(3,\)"),
        (dict(points=np.zeros((1, 1, 1, 3))), ValueError, "expected shape"),
        (dict(points=[[0, 0, 1], [0, np.nan, 0]]), ValueError, r"points\[1\]: expected finite"),
        (dict(points=[[0, 0, 1], [0, 0, 0]]), ValueError, r"points\[1\].*length 0"),
        (dict(points=[[[0, 0, 1], [0, 3, 4]]]), ValueError, r"points\[0, 1\].*length 5.0"),
        (dict(points=[[0, 0, 1e308], [0, 0, 1]]), ValueError, r"points\[0\]: expected a unit"),
        (dict(points=[["a", "b", "c"]]), TypeError, "points: expected real numbers"),
        (dict(points=None), TypeError, "points: expected real numbers"),
        (dict(points=[[0, 0, 1j]]), TypeError, "complex128"),
        (dict(points=[[False, False, True]]), TypeError, "bool"),
        (dict(weights=[1.0, 2]), ValueError, r"weights: expected shape \(1,\), got \(2,\)"),
        (dict(weights=1.0), ValueError, r"weights: expected shape \(1,\), got \(\)"),
        (dict(weights=[1j]), TypeError, "weights: expected real numbers"),
        (dict(weights=[np.inf]), ValueError, r"weights\[0\]: expected a finite number, got inf"),
        (dict(lmax=-1), ValueError, "lmax: expected a whole number from 0 to 1000000, got -1"),
        (dict(lmax=1000001), ValueError, "got 1000001"),
        (dict(lmax=10**30), ValueError, "got 10{30}"),
        (dict(lmax=1.0), TypeError, "lmax: expected a whole number, got float"),
        (dict(lmax=None), TypeError, "got NoneType"),
        (dict(lmax=1000000), MemoryError, "points2alm of 1 points to degree 1000000 requires"),
        (dict(epsilon=0), ValueError, "epsilon must be in"),
        (dict(epsilon=np.nan), ValueError, "epsilon must be in"),
        (dict(method="slow"), ValueError, 'method: expected "auto", "exact" or "fast"'),
    ],
)
def test_invalid_arguments_are_named(change, kind, message):
    arguments = dict(points=[[0, 0, 1.0]], lmax=2) | change
    points, lmax = arguments.pop("points"), arguments.pop("lmax")
    with pytest.raises(kind, match=message):
        sphvar.points2alm(points, lmax, **arguments)


@pytest.mark.parametrize(
    ("alm", "points", "kind", "message"),
    [
        ([], [[0, 0, 1]], ValueError, "got 0"),
        ([[1.0]], [[0, 0, 1]], ValueError, r"alm: expected shape"),
        ([1, np.nan, 0], [[0, 0, 1]], ValueError, r"alm\[1\]: expected a finite number"),
        ([1.0], [0, 0, 1], ValueError, r"points: expected shape \(..., 3\), got \(3,\)"),
        ([1.0], [[[0, 0, 1], [0, 0, 2]]], ValueError, r"points\[0, 1\]: expected a unit vector"),
        (["1"], [[0, 0, 1]], TypeError, "alm: expected numbers"),
    ],
)
def test_invalid_coefficients_are_named(alm, points, kind, message):
    with pytest.raises(kind, match=message):
        sphvar.alm2points(alm, points)


def test_two_threads_have_the_results_of_one():
    points = random_points(30000)
    expected = sphvar.points2alm(points, 80)
    results = [None, None]

    def work(i):
        results[i] = sphvar.points2alm(points, 80)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(result, expected) for result in results)


def test_progress_is_told_and_stops():
    sets = random_points(40 * 5000).reshape(40, 5000, 3)
    told = []
    sphvar.points2alm(sets, 64, progress=lambda done, expected: told.append((done, expected)))
    assert told[-1][0] == pytest.approx(told[-1][1])

    def stop(done, expected):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        sphvar.points2alm(sets, 64, progress=stop)
