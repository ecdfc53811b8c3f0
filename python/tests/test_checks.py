"""Checks of arguments before work: degrees, counts and seeds, masked arrays, and memory."""

from __future__ import annotations

import signal
import subprocess
import sys
import textwrap
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import sphvar

POINTS = sphvar.Sampler("fibonacci", 48).random(1)[0]
MASKED = np.ma.masked_array(POINTS, mask=POINTS < 0)
UNMASKED = np.ma.masked_array(POINTS, mask=np.zeros(POINTS.shape, dtype=bool))
NUMBERS = np.ma.masked_less(np.arange(48.0), 2)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda n: sphvar.Sampler("fibonacci", n), "n"),
        (lambda n: sphvar.Sampler("fibonacci", 4, seed=n), "seed"),
        (lambda n: sphvar.Sampler("fibonacci", 4).random(n), "m"),
        (lambda n: sphvar.Sampler("fibonacci", 4).fast_forward(n), "k"),
        (lambda n: sphvar.rotations("uniform", n), "n"),
        (lambda n: sphvar.rotations("uniform", 4, n), "realizations"),
        (lambda n: sphvar.spectrum("fibonacci", 16, lmax=n), "lmax"),
        (lambda n: sphvar.spectrum("fibonacci", 16, realizations=n), "realizations"),
        (lambda n: sphvar.spectrum("fibonacci", 16, seed=n), "seed"),
        (lambda n: sphvar.weights(POINTS, degree=n), "degree"),
        (lambda n: sphvar.fit(POINTS, POINTS[:, 0], n), "lmax"),
        (lambda n: sphvar.energies("cosine", n), "lmax"),
        (lambda n: sphvar.points2alm(POINTS, n), "lmax"),
        (lambda n: sphvar.Function(np.sum, degree=n), "degree"),
        (lambda n: sphvar.Function(np.sum, max_evaluations=n), "max_evaluations"),
        (lambda n: sphvar.Energies([1.0], field=n), "field"),
    ],
)
def test_whole_numbers_are_checked_under_their_names(call: Callable[[Any], Any], name: str) -> None:
    for wrong in (1.5, "3", True, np.True_, [1]):
        with pytest.raises(TypeError, match=f"^{name}: expected a whole number, got "):
            call(wrong)
    for outside in (-1, -(10**30)):
        with pytest.raises(ValueError, match=f"^{name}(:| must be) .*got {outside}"):
            call(outside)


@pytest.mark.parametrize(
    "call",
    [
        lambda n: sphvar.energies("cosine", n),
        lambda n: sphvar.spectrum("fibonacci", 16, lmax=n),
        lambda n: sphvar.weights(POINTS, degree=n),
        lambda n: sphvar.fit(POINTS, POINTS[:, 0], n),
        lambda n: sphvar.points2alm(POINTS, n),
        lambda n: sphvar.Function(np.sum, degree=n),
    ],
)
@pytest.mark.parametrize("degree", [1_000_001, 10**12, 10**30])
def test_degrees_have_a_limit(call: Callable[[int], Any], degree: int) -> None:
    with pytest.raises(ValueError, match="from 0 to 1000000, got"):
        call(degree)


def test_given_points_have_a_number_of_their_own() -> None:
    assert sphvar.Sampler(POINTS, 48).n == sphvar.Sampler(POINTS).n == 48
    with pytest.raises(ValueError, match="n = 16, but there are 48 points"):
        sphvar.Sampler(POINTS, 16)


@pytest.mark.parametrize("wrong", [5, 1.5, None, b"fibonacci", ["fibonacci"]])
def test_a_sampler_is_a_text_or_points(wrong: Any) -> None:
    with pytest.raises(TypeError, match="a sampler is a text, an array of points or a tuple"):
        sphvar.Sampler(wrong)


def test_sums_that_overflow_are_errors() -> None:
    with pytest.raises(ValueError, match="^weights: "):
        sphvar.points2alm(POINTS, 1, weights=np.full(48, 1e308))
    with pytest.raises(ValueError, match="^alm: "):
        sphvar.alm2points(np.full(45, 1.7e308), POINTS)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: sphvar.Sampler(MASKED), "points"),
        (lambda: sphvar.Sampler((POINTS, NUMBERS)), "weights"),
        (lambda: sphvar.spectrum(MASKED, lmax=2), "points"),
        (lambda: sphvar.spectrum(POINTS, lmax=2, weights=NUMBERS), "weights"),
        (lambda: sphvar.points2alm(MASKED, 2), "points"),
        (lambda: sphvar.points2alm(POINTS, 2, weights=NUMBERS), "weights"),
        (lambda: sphvar.alm2points(NUMBERS[:3], POINTS), "alm"),
        (lambda: sphvar.evaluate("cosine", MASKED), "points"),
        (lambda: sphvar.weights(MASKED, degree=1), "points"),
        (lambda: sphvar.fit(POINTS, NUMBERS, 1), "values"),
        (lambda: sphvar.fit(POINTS, POINTS[:, 0], 1, sigma=NUMBERS), "errors"),
        (lambda: sphvar.Coefficients(NUMBERS[:3]), "alm"),
        (lambda: sphvar.Energies(NUMBERS), "values"),
        (lambda: sphvar.Environment(np.ma.masked_less(np.eye(4, 8), 1)), "image"),
        (lambda: sphvar.healpix.pix2vec(4, np.ma.masked_less(np.arange(9), 2)), "ipix"),
        (lambda: sphvar.evaluate(lambda p: np.ma.masked_less(p[:, 2], 0), POINTS), "the values of "),
    ],
)
def test_masked_elements_are_errors(call: Callable[[], Any], name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name}.*masked"):
        call()


def test_arrays_with_an_empty_mask_are_arrays() -> None:
    plain = sphvar.points2alm(POINTS, 3)
    assert np.array_equal(sphvar.points2alm(UNMASKED, 3), plain)
    assert np.array_equal(sphvar.points2alm(np.ma.array(POINTS), 3), plain)
    assert np.array_equal(sphvar.Sampler(UNMASKED).random(), sphvar.Sampler(POINTS).random())
    assert np.array_equal(sphvar.evaluate("cosine", UNMASKED), sphvar.evaluate("cosine", POINTS))


def test_masked_pixels_are_missing() -> None:
    values = np.ma.masked_less(np.arange(12), 1)
    directions = np.eye(3)
    with pytest.raises(ValueError, match="1 pixels of the map have no value"):
        sphvar.evaluate(values, directions)
    filled = sphvar.evaluate(sphvar.HealpixMap(values, missing="0"), directions)
    assert np.array_equal(filled, sphvar.evaluate(np.arange(12.0), directions))
    assert not np.isnan(values.data.astype(float)).any()


@pytest.mark.parametrize(
    "call",
    [
        "sphvar.spectrum(points, lmax=2)",
        "sphvar.weights(points, degree=2)",
        "sphvar.fit(points, points[:, 0], 2)",
        "sphvar.evaluate('cosine', points)",
        "sphvar.points2alm(points, 2)",
        "sphvar.alm2points([1.0], points)",
        "sphvar.Sampler(points)",
        "sphvar.predict(points, integrand='cosine')",
        "sphvar.healpix.vec2pix(4, *points.T)",
        "sphvar.energies('cosine', 10**6) is sphvar.energies(np.zeros(12), 10**6)",
    ],
)
def test_memory_is_checked_before_it_is_taken(call: str) -> None:
    """An array without memory of its own stands for more than the machine has."""
    program = textwrap.dedent(f"""
        import numpy as np, sphvar
        points = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (10**12, 3))
        try:
            {call}
        except (MemoryError, RuntimeError) as error:
            print(error)
    """)
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=30)
    assert run.returncode == 0 and ("memory" in run.stdout or "allocate" in run.stdout), run


@pytest.mark.parametrize("order", ["F", "reversed", "every other", "transposed", "float32", "big-endian"])
def test_arrays_of_every_layout_have_the_same_bits(order: str) -> None:
    # More elements than a part of a copy has.
    points = sphvar.Sampler("white-noise", 180_000, seed=3).random(3)
    if order == "F":
        array = np.asfortranarray(points)
    elif order == "reversed":
        array = np.ascontiguousarray(points[::-1, ::-1])[::-1, ::-1]
    elif order == "every other":
        array = np.repeat(points, 2, axis=1)[:, ::2]
    elif order == "transposed":
        array = np.ascontiguousarray(points.transpose(2, 1, 0)).transpose(2, 1, 0)
    elif order == "float32":
        array = points.astype(np.float32)
        points = array.astype(np.float64)
    else:
        array = points.astype(">f8")
    assert order in ("float32",) or not array.flags.c_contiguous or array.dtype != np.float64
    drawn = sphvar.spectrum(array, lmax=2)
    assert np.array_equal(drawn.power, sphvar.spectrum(points, lmax=2).power)


def test_rows_that_need_a_message_are_found_among_others() -> None:
    points = np.repeat(POINTS, 100, axis=0)
    points[4321] = 0.0
    with pytest.raises(ValueError, match=r"points\[4321\]"):
        sphvar.spectrum(points, lmax=2)
    points[4321] = [0.0, np.nan, 1.0]
    with pytest.raises(ValueError, match=r"points\[4321\].*finite"):
        sphvar.spectrum(points, lmax=2)
    points[4321] = [0.0, 0.0, 2.0]
    with pytest.warns(sphvar.SphvarWarning, match=r"1 of 4800 vectors .*points\[4321\], length 2"):
        sphvar.spectrum(points, lmax=2)
    weights = np.ones(4800)
    weights[7] = np.inf
    with pytest.raises(ValueError, match=r"points\[7\]: w"):
        sphvar.spectrum(POINTS.repeat(100, axis=0), lmax=2, weights=weights)


def test_a_function_that_calls_itself_without_end_is_an_error() -> None:
    def endless(points: np.ndarray[Any, Any]) -> Any:
        return sphvar.evaluate(endless, points)

    with pytest.raises(RecursionError):
        sphvar.integrate(endless)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers")
def test_copies_are_interrupted() -> None:
    """The elements of 1.2 GB come from three numbers, so that only the copy takes time."""
    program = """
import os, signal, time
import numpy as np, sphvar
points = np.broadcast_to(np.array([0.0, 0.0, 1.0]), (50_000_000, 3))
signal.signal(signal.SIGALRM, signal.default_int_handler)
signal.setitimer(signal.ITIMER_REAL, 0.05)
start = time.monotonic()
try:
    sphvar.spectrum(points, lmax=0)
except KeyboardInterrupt:
    print(time.monotonic() - start)
    os._exit(0)
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert run.returncode == 0 and float(run.stdout) < 5.0, run
