"""Integrals of callables to a tolerance, beside the command and rules of Lebedev."""

import json
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest

import sphvar

AXIS = np.array([2.0, -1.0, 2.0]) / 3


def smooth(points: np.ndarray) -> np.ndarray:
    return np.exp(points[:, 0])


def lobe(points: np.ndarray) -> np.ndarray:
    return np.exp(20 * (points @ AXIS - 1))


def narrow(points: np.ndarray) -> np.ndarray:
    return np.exp(200 * (points @ AXIS - 1))


def ridge(points: np.ndarray) -> np.ndarray:
    return np.abs(points @ AXIS)


def clamped(points: np.ndarray) -> np.ndarray:
    return np.maximum(points @ AXIS, 0.0) ** 2


def cap(points: np.ndarray) -> np.ndarray:
    return (points @ AXIS > 0.3).astype(float)


#: Callables and their integrals.
FUNCTIONS = [
    (smooth, 4 * np.pi * np.sinh(1)),
    (lobe, 2 * np.pi * -np.expm1(-40) / 20),
    (narrow, 2 * np.pi / 200),
    (ridge, 2 * np.pi),
    (clamped, 2 * np.pi / 3),
    (cap, 2 * np.pi * 0.7),
]

#: The degrees of the rules of Lebedev that scipy has.
DEGREES = [*range(3, 32, 2), *range(35, 132, 6)]


def lebedev(function, exact: float, rtol: float) -> tuple[int, float]:
    """Return the points of a loop over rules until two of them agree, and the error; 0 if none do."""
    from scipy.integrate import lebedev_rule

    points, before = 0, np.inf
    for degree in DEGREES:
        x, w = lebedev_rule(degree)
        points += w.size
        value = float(w @ function(np.ascontiguousarray(x.T)))
        if abs(value - before) <= rtol * abs(value):
            return points, abs(value / exact - 1)
        before = value
    return 0, abs(value / exact - 1)


def test_integrals_meet_their_tolerance_beside_loops_over_lebedev_rules() -> None:
    pytest.importorskip("scipy", minversion="1.15")
    rtol, rows = 1e-4, []
    # The first calls import and start threads.
    lebedev(smooth, FUNCTIONS[0][1], rtol)
    sphvar.integrate(smooth)
    for function, exact in FUNCTIONS:
        started = time.perf_counter()
        integral = sphvar.integrate(function, rtol=rtol)
        between = time.perf_counter()
        points, error = lebedev(function, exact, rtol)
        ended = time.perf_counter()
        rows.append((function.__name__, integral.evaluations, between - started, points, error, ended - between))
        assert integral.converged and integral.error <= rtol * abs(integral.value)
        assert abs(integral.value - exact) <= 2 * integral.error
    for name, evaluations, seconds, points, error, theirs in rows:
        print(f"{name:8} {evaluations:8} {1e3 * seconds:8.1f} ms {points:8} {error:.1e} {1e3 * theirs:8.1f} ms")
    # The rules agree for smooth functions only; that of the jump stops far from its integral, or never.
    by_name = {row[0]: row for row in rows}
    assert by_name["smooth"][4] < 1e-4
    assert by_name["cap"][3] == 0 or by_name["cap"][4] > rtol


def test_nodes_and_weights_give_the_value() -> None:
    integral = sphvar.integrate(lobe, rtol=1e-3, hemisphere=True)
    assert integral.nodes.shape == (integral.copies * integral.n, 3)
    assert (integral.nodes[:, 2] >= 0).all()
    assert integral.weights.sum() == pytest.approx(2 * np.pi, rel=1e-13)
    assert integral.weights @ lobe(integral.nodes) == pytest.approx(integral.value, rel=1e-12)


def test_several_components_come_from_the_same_points() -> None:
    def moments(points: np.ndarray) -> np.ndarray:
        return np.stack([lobe(points), ridge(points), points[:, 2] ** 2], axis=1)

    integral = sphvar.integrate(moments, rtol=1e-3)
    assert integral.converged and integral.value.shape == integral.error.shape == (3,)
    for value, error, exact in zip(integral.value, integral.error, [FUNCTIONS[1][1], 2 * np.pi, 4 * np.pi / 3]):
        assert abs(value - exact) <= 2 * error
    single = sphvar.integrate(lambda points: ridge(points)[:, None], rtol=1e-3)
    assert single.value.shape == (1,)
    assert single.value[0] == sphvar.integrate(ridge, rtol=1e-3).value

    def uneven(points: np.ndarray) -> np.ndarray:
        return np.zeros((len(points), 2 if len(points) == 5 else 3))

    with pytest.raises(ValueError, match=r"expected \(\d+, 2\)"):
        sphvar.integrate(uneven)


def test_the_numbers_are_those_of_the_command() -> None:
    words = ["integrate", "--integrand=vmf:kappa=20 @ 30/40", "--rtol=0.001", "--seed=5", "--hemisphere"]
    done = subprocess.run(
        [sys.executable, "-m", "sphvar._command", *words, "--json"], capture_output=True, check=True
    )
    theirs = json.loads(done.stdout)
    ours = sphvar.integrate("vmf:kappa=20 @ 30/40", rtol=1e-3, seed=5, hemisphere=True).to_dict()
    for key in ("value", "error", "exact", "n", "copies", "evaluations", "stop", "sampler", "integrand"):
        assert ours[key] == theirs[key], key


def test_a_tolerance_that_is_not_met_is_a_warning() -> None:
    with pytest.warns(sphvar.SphvarWarning, match="the tolerance is not met"):
        integral = sphvar.integrate(cap, rtol=1e-6, max_points=10_000)
    assert not integral.converged and integral.message is not None
    assert integral.stop == "max-points" and integral.evaluations <= 10_000
    with pytest.warns(sphvar.SphvarWarning, match="give atol=|equal"):
        sphvar.integrate(lambda points: 0 * points[:, 0], max_points=10_000)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sphvar.integrate(lambda points: points[:, 0] ** 3, atol=1e-3).converged


def test_invalid_options_are_errors_before_anything_runs() -> None:
    def never(points: np.ndarray) -> np.ndarray:
        assert len(points) == 5, "only the probe"
        return points[:, 2]

    for options, kind, words in [
        ({"rtol": -1.0}, ValueError, "for rtol"),
        ({"rtol": 0.0}, ValueError, "tolerance"),
        ({"rtol": np.nan}, ValueError, "rtol"),
        ({"sampler": "fibonaci"}, ValueError, "fibonacci"),
        ({"max_points": 3}, ValueError, "evaluations"),
        ({"max_points": 1.5}, (TypeError, ValueError), "max_points"),
        ({"seed": -1}, ValueError, "seed"),
        ({"tolerance": 1e-3}, TypeError, "rtol|atol"),
        ({"sampler": ["healpix", "fibonacci"]}, ValueError, "expected one"),
    ]:
        with pytest.raises(kind, match=words):
            sphvar.integrate(never, **options)


def test_exact_integrals_are_known_for_a_given_degree_only() -> None:
    assert sphvar.integrate(ridge, rtol=1e-2).exact is None
    given = sphvar.Function(ridge, degree=1, edges=[(AXIS, 90)])
    integral = sphvar.integrate(given, rtol=1e-2)
    assert integral.exact == pytest.approx(2 * np.pi, rel=1e-12)
    assert "value" in repr(integral) and float(integral) == integral.value
