"""Callables, arrays and images as integrands: values, energies, and what is wrong with them."""

import os
import pickle
import signal
import sys
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sphvar

Z = np.array([0.0, 0.0, 1.0])


def sphere_points(n: int) -> np.ndarray:
    points = np.random.default_rng(7).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def wave(points: np.ndarray) -> np.ndarray:
    return (3 * points[:, 2] ** 2 - 1) * np.sqrt(5 / (16 * np.pi))


def kink(points: np.ndarray) -> np.ndarray:
    return np.maximum(points[:, 2], 0.0)


def test_values_and_energies_are_those_of_built_in_functions() -> None:
    points = sphere_points(1000)
    for function, known in [(wave, "ylm:l=2"), (kink, "cosine")]:
        got, expected = sphvar.evaluate(function, points), sphvar.evaluate(known, points)
        assert np.abs(got - expected).max() < 1e-14
    # A degree that is found, given, and with an edge: to rounding. A kink: to some digits.
    for function, known, tolerance in [
        (wave, "ylm:l=2", 1e-12),
        (sphvar.Function(wave, degree=2), "ylm:l=2", 1e-12),
        (sphvar.Function(kink, degree=1, edges=[(Z, 90)]), "cosine", 1e-12),
        (kink, "cosine", 1e-5),
    ]:
        for hemisphere in (False, True):
            got = sphvar.energies(function, 20, hemisphere=hemisphere)
            expected = sphvar.energies(known, 20, hemisphere=hemisphere)
            assert np.abs(got - expected).max() <= tolerance * expected.sum()


def test_expressions_have_functions_of_their_own() -> None:
    points = sphere_points(200)
    ring = np.arange(48.0)
    given = sphvar.Expression("2 * f @ 30/0 - m * cosine", f=wave, m=ring)
    expected = 2 * sphvar.evaluate("ylm:l=2 @ 30/0", points)
    expected -= sphvar.evaluate(ring, points) * np.maximum(points[:, 2], 0)
    assert np.abs(sphvar.evaluate(given, points) - expected).max() < 1e-12
    filtered = sphvar.Expression('filtered:fwhm=20,of="f + cosine"', f=wave)
    known = 'filtered:fwhm=20,of="ylm:l=2 + cosine"'
    difference = sphvar.energies(filtered, 10) - sphvar.energies(known, 10)
    assert np.abs(difference).max() < 1e-12
    with pytest.raises(ValueError, match="g is not in the expression"):
        sphvar.Expression("2 * f", f=wave, g=wave)


def test_arrays_are_integrands_by_their_shape() -> None:
    sph_harm_y = pytest.importorskip("scipy.special").sph_harm_y

    points = sphere_points(300)
    constant = np.full((8, 16), 0.25)
    assert np.abs(sphvar.evaluate(constant, points) - 0.25).max() < 1e-12
    colour = np.stack([constant, constant, constant], axis=2).astype(np.float32)
    assert np.abs(sphvar.evaluate(colour, points) - 0.25).max() < 1e-6
    alm = np.zeros(6, dtype=complex)
    alm[1], alm[4] = 0.5, 0.25 - 0.5j
    theta, phi = np.arccos(points[:, 2]), np.arctan2(points[:, 1], points[:, 0])
    expected = 0.5 * sph_harm_y(1, 0, theta, phi).real
    expected = expected + 2 * (alm[4] * sph_harm_y(2, 1, theta, phi)).real
    assert np.abs(sphvar.evaluate(alm, points) - expected).max() < 1e-12


def test_maps_in_either_order_are_those_of_healpy() -> None:
    healpy = pytest.importorskip("healpy")
    points, nside = sphere_points(500), 8
    values = np.random.default_rng(1).normal(size=12 * nside * nside)
    pixels = healpy.vec2pix(nside, *points.T)
    assert np.array_equal(sphvar.evaluate(values, points), values[pixels])
    nested = sphvar.HealpixMap(healpy.reorder(values, r2n=True), nest=True)
    assert np.array_equal(sphvar.evaluate(nested, points), values[pixels])
    values[5] = healpy.UNSEEN
    with pytest.raises(ValueError, match="no value"):
        sphvar.evaluate(values, points)
    centre = np.stack(healpy.pix2vec(nside, [5]), axis=1)
    assert sphvar.evaluate(sphvar.HealpixMap(values, missing="0"), centre)[0] == 0.0


@pytest.mark.parametrize(
    ("value", "kind", "words"),
    [
        (np.zeros(13), ValueError, "HealpixMap, Environment, Coefficients or Energies"),
        (np.zeros((5, 3)), ValueError, "HealpixMap, Environment, Coefficients or Energies"),
        (np.zeros(0), ValueError, "HealpixMap"),
        (np.zeros((8, 16), dtype=np.uint8), TypeError, "8-bit"),
        (None, TypeError, "NoneType"),
        (object(), TypeError, "object"),
        ("cosin", ValueError, "cosine"),
        ([[1, 2], [3]], ValueError, "expected a text"),
        (lambda p: p[2], ValueError, "must be vectorized"),
        (lambda p: float(p[0]) + 1.0, ValueError, "must be vectorized"),
        (lambda p: 1.0, ValueError, r"returned shape \(\) for 5 directions"),
        (lambda p: p, ValueError, "3 values for a direction"),
        (lambda p: p[:, 2] + 1j, TypeError, "complex128"),
        (lambda p: [str(x) for x in p[:, 2]], TypeError, "dtype"),
        (lambda p: p[:-1, 2], ValueError, r"returned shape \(4,\) for 5 directions, expected \(5,\)"),
        (lambda p: p.sort() or p[:, 2], ValueError, "read-only"),
    ],
)
def test_what_is_no_integrand_is_an_error(value: object, kind: type, words: str) -> None:
    with pytest.raises(kind, match=words):
        sphvar.evaluate(value, [Z])


def test_values_that_are_not_finite_are_reported_with_the_direction() -> None:
    for value, words in [(np.nan, "nan"), (np.inf, "inf"), (-np.inf, "-inf")]:

        def singular(points: np.ndarray) -> np.ndarray:
            return np.where(points[:, 0] > 0.99, value, points[:, 2])

        message = rf"singular returned {words} at \(1, 0, 0\), theta = 90.0000, phi = 0.0000"
        with pytest.raises(ValueError, match=message):
            sphvar.evaluate(singular, [Z, [1, 0, 0]])
        # Quadratures, trials and integrals meet the same directions.
        for question in (
            lambda: sphvar.energies(singular, 10),
            lambda: sphvar.energies(sphvar.Expression("f * cosine", f=singular), 10),
            lambda: sphvar.integrate(singular, rtol=1e-9, max_points=1_000_000),
        ):
            with pytest.raises(ValueError, match=f"(singular|f) returned {words} at"):
                question()


class OwnError(Exception):
    pass


@pytest.mark.skipif(sys.version_info < (3, 11), reason="exceptions have notes from CPython 3.11 on")
def test_exceptions_of_a_callable_are_raised_as_themselves() -> None:
    def fails(points: np.ndarray) -> np.ndarray:
        if (points[:, 2] < -0.5).any():
            raise OwnError("no ground")
        return points[:, 2]

    for question in (
        lambda: sphvar.evaluate(fails, [Z, [0.6, 0, 0.8], [0, 0, -1]]),
        lambda: sphvar.energies(fails, 4),
        lambda: sphvar.integrate(fails),
        lambda: sphvar.energies(sphvar.Expression("0.5 * cosine + f @ 20/10", f=fails), 4),
    ):
        with pytest.raises(OwnError, match="no ground") as caught:
            question()
        assert any("fails" in str(frame) for frame in caught.traceback)
        if sys.version_info >= (3, 11):
            assert any(" was called at (" in note for note in caught.value.__notes__)
    with pytest.raises(KeyboardInterrupt):

        def interrupts(points: np.ndarray) -> np.ndarray:
            if len(points) > 5:
                raise KeyboardInterrupt
            return points[:, 2]

        sphvar.energies(interrupts, 4)
    # The next question does not know of it.
    assert sphvar.evaluate(kink, [Z])[0] == 1.0


@pytest.mark.skipif(sys.version_info < (3, 11), reason="exceptions have notes from CPython 3.11 on")
def test_functions_above_the_equator_are_not_evaluated_below() -> None:
    def growing(points: np.ndarray) -> np.ndarray:
        assert (points[:, 2] >= 0).all()
        return np.exp(points[:, 2])

    assert sphvar.energies(growing, 4, hemisphere=True).shape == (5,)
    with pytest.raises(AssertionError):
        sphvar.energies(growing, 4)
    above = sphvar.Function(growing, hemisphere=True)
    product = sphvar.Expression("f * cosine", f=above)
    got = sphvar.energies(product, 0, hemisphere=True)[0]
    # int z e^z over the hemisphere is 2 pi; the even extension has twice the integral.
    assert got == pytest.approx(4 * np.pi, rel=1e-10)


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int64, np.bool_, ">f8"])
def test_results_of_every_number_type(dtype: object) -> None:
    def sign(points: np.ndarray) -> np.ndarray:
        return (points[:, 2] > 0).astype(dtype)

    assert list(sphvar.evaluate(sign, [Z, -Z])) == [1.0, 0.0]
    strided = sphvar.evaluate(lambda p: np.repeat(p[:, 2], 2)[::2], [Z, -Z])
    assert list(strided) == [1.0, -1.0]
    assert list(sphvar.evaluate(lambda p: list(p[:, 2]), [Z, -Z])) == [1.0, -1.0]


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(-(10**6), 10**6).map(float), min_size=12, max_size=12), st.booleans())
def test_maps_return_their_values(values: list[float], nest: bool) -> None:
    # At nside 1 both orders are the same.
    centres = sphvar.healpix.pix2vec(1, np.arange(12), nest=nest)
    points = np.stack(centres, axis=1)
    assert list(sphvar.evaluate(sphvar.HealpixMap(values, nest=nest), points)) == values


def test_points_of_evaluate_are_checked() -> None:
    for points, words in [
        ([[0.0, 0.0, 2.0]], r"points\[0\] = \(0, 0, 2\) is not a unit vector"),
        ([[0.0, 0.0]], r"expected shape \(n, 3\), got \(1, 2\)"),
        ([[np.nan, 0.0, 0.0]], "not a unit vector"),
    ]:
        with pytest.raises(ValueError, match=words):
            sphvar.evaluate("cosine", points)
    assert sphvar.evaluate("cosine", np.zeros((0, 3))).shape == (0,)
    fortran = np.asfortranarray(sphere_points(50).astype(np.float32))
    fortran.flags.writeable = False
    assert sphvar.evaluate(kink, fortran).shape == (50,)


def test_a_callable_may_call_the_package_and_run_in_threads() -> None:
    def nested(points: np.ndarray) -> np.ndarray:
        return sphvar.evaluate("cosine", points) + sphvar.evaluate(wave, points)

    results: list[float] = []
    threads = [
        threading.Thread(target=lambda: results.append(float(sphvar.integrate(nested, rtol=1e-3))))
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(timeout=60)
    assert results == results[:1] * 4
    assert results[0] == pytest.approx(np.pi, rel=2e-3)


def test_wrappers_state_what_is_wrong() -> None:
    for make, kind, words in [
        (lambda: sphvar.Function(3), TypeError, "callable"),
        (lambda: sphvar.Function(kink, edges=[(Z, 90)]), ValueError, "degree"),
        (lambda: sphvar.Function(kink, degree=3, tolerance=1e-3), ValueError, "tolerance"),
        (lambda: sphvar.HealpixMap(np.zeros(13)), ValueError, r"\(13,\)"),
        (lambda: sphvar.HealpixMap(["a"] * 12), TypeError, "real numbers"),
        (lambda: sphvar.Coefficients(np.zeros(4)), ValueError, r"\(4,\)"),
        (lambda: sphvar.Energies([]), ValueError, r"\(0,\)"),
        (lambda: sphvar.Energies([1.0], quantity="dl"), ValueError, "'dl'"),
        (lambda: sphvar.Environment(np.zeros((3, 6, 2))), ValueError, r"\(3, 6, 2\)"),
        (lambda: sphvar.energies(sphvar.Function(kink, tolerance=2.0), 1), ValueError, "at most 0.1"),
        (lambda: sphvar.energies(sphvar.Function(kink, degree=1, edges=[(0 * Z, 9)]), 1), ValueError, "axis"),
        (lambda: sphvar.Energies([1.0, -2.0]) and sphvar.energies(sphvar.Energies([1.0, -2.0]), 1), ValueError, "from 0, got -2"),
    ]:
        with pytest.raises(kind, match=words):
            make()


#: The probability that a correct variance differs by more, two-sided: 40 cells have false alarms in
#: 1 of 400 runs with other seeds; with the seed below the result is always the same.
MAX_Z = 4.0


def test_a_callable_of_ones_own_is_predicted_and_measured() -> None:
    def peaked(points: np.ndarray) -> np.ndarray:
        return np.exp(8 * (points @ np.array([0.6, 0.0, 0.8]) - 1))

    def jump(points: np.ndarray) -> np.ndarray:
        return (points @ np.array([0.36, 0.48, 0.8]) > 0.5).astype(float)

    def ripple(points: np.ndarray) -> np.ndarray:
        return np.sin(7 * points[:, 0]) * points[:, 1] + 1

    # Fewer values than the default have larger errors, which the scores take into account.
    known = {"max_evaluations": 1 << 18}
    functions = [peaked, sphvar.Function(jump, **known), ripple, sphvar.Function(kink, **known)]
    scores = []
    for function in functions:
        result = sphvar.compare(
            ["white-noise", "jittered", "fibonacci", "healpix", "halton"],
            n=[48, 192],
            integrand=function,
            realizations=400,
            seed=3,
        )
        scores += [row["z"] for row in result.rows]
    assert len(scores) == 40
    assert np.abs(scores).max() < MAX_Z, scores
    # They are scores: neither all small nor all of one sign.
    assert 0.5 < np.std(scores) < 1.5 and abs(np.mean(scores)) < 0.6, scores


def test_signals_stop_work_with_slow_callables() -> None:
    def slow(points: np.ndarray) -> np.ndarray:
        time.sleep(0.01)
        return points[:, 2]

    for question in (
        lambda: sphvar.integrate(slow, rtol=1e-12, max_points=10**8),
        lambda: sphvar.compare("fibonacci", n=64, integrand=slow, realizations=10**5),
    ):
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        started = time.perf_counter()
        with pytest.raises(KeyboardInterrupt):
            question()
        timer.join()
        assert time.perf_counter() - started < 0.3 + 1.5


@pytest.mark.parametrize(
    "make",
    [
        lambda number: sphvar.HealpixMap(np.full(12, number)),
        lambda number: sphvar.Environment(np.full((4, 8), number)),
        lambda number: sphvar.Coefficients(np.full(3, number)),
        lambda number: sphvar.Energies([0, number]),
        lambda number: sphvar.Expression("f * cosine", f=np.full(12, number)),
        lambda number: sphvar.Function(abs, degree=int(number)),
    ],
)
def test_wrappers_compare_by_what_they_hold(make):
    one, same, other = make(1.0), make(1.0), make(2.0)
    assert one == same
    assert one == pickle.loads(pickle.dumps(one))
    assert one != other
    assert one != "cosine"


def test_arithmetic_of_wrappers_names_expressions():
    sky = sphvar.Environment(np.ones((4, 8)))
    for combine in (
        lambda: sky * sphvar.Expression("cosine"),
        lambda: 2 * sky,
        lambda: np.ones(3) * sky,
        lambda: sky + sky,
    ):
        with pytest.raises(TypeError, match="Expression combines integrands"):
            combine()


def test_what_is_masked_is_missing():
    values = np.ma.masked_less(np.arange(192.0), 4)
    with pytest.raises(ValueError):
        sphvar.predict("fibonacci", n=100, integrand=values)
    filled = sphvar.HealpixMap(np.where(values.mask, np.nan, values.data), missing="mean")
    assert sphvar.HealpixMap(values, missing="mean") == filled
    for call in (
        lambda mask: sphvar.Environment(np.ma.array(np.ones((4, 8)), mask=mask)),
        lambda mask: sphvar.Coefficients(np.ma.array([1.0, 0, 0], mask=mask)),
        lambda mask: sphvar.Sampler(np.ma.array([[1.0, 0, 0], [0, 1, 0]], mask=mask)),
        lambda mask: sphvar.spectrum(np.ma.array([[1.0, 0, 0], [0, 1, 0]], mask=mask), lmax=2),
        lambda mask: sphvar.quality(np.ma.array([[1.0, 0, 0], [0, 1, 0]], mask=mask)),
    ):
        call(False)
        with pytest.raises(ValueError, match="elements are masked"):
            call(True)


def test_an_array_of_truth_values_is_rejected_by_its_dtype():
    with pytest.raises(TypeError, match="ndarray of dtype bool"):
        sphvar.integrate(np.arange(192) < 96)
