"""Typical uses, which mypy checks strictly; nothing here is run."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import assert_type

import sphvar


def radiance(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values of a function of direction."""
    return np.asarray(np.exp(directions[:, 2]), dtype=np.float64)


def questions(points: NDArray[np.float64], weights: NDArray[np.float64]) -> None:
    """Ask about samplers of all kinds, and integrands of all kinds."""
    assert_type(sphvar.choose(integrand=radiance, n=100), sphvar.ChoiceResult)
    sphvar.choose(["fibonacci", points], integrand="cosine", error="1%")
    sphvar.choose(integrand=sphvar.Expression("2 * f - cosine", f=radiance), error=0.01)
    table = sphvar.compare(
        {"mine": points, "weighted": (points, weights), "theirs": "fibonacci"},
        n=[100, 200],
        integrand=sphvar.Function(radiance, degree=40),
        realizations=200,
        progress=True,
    )
    assert_type(table, sphvar.ComparisonResult)
    assert_type(table.predicted, NDArray[Any])
    assert_type(table.samplers, list[dict[str, Any]])
    assert_type(table.best, dict[str, Any] | None)
    table.plot().set_title("errors")
    for row in table:
        assert_type(row, dict[str, Any])
    assert_type(table[0], dict[str, Any])
    assert_type(len(table), int)
    assert_type(sphvar.predict("jittered", n=range(10, 20), integrand=np.ones(12)).n, NDArray[Any])
    sphvar.measure(sphvar.Sampler("ccvt", 64), integrand=np.ones((8, 16, 3)), seed=3)
    sphvar.progressive("sobol", n="16..1024", integrand="vmf:kappa=10", reference="healpix")
    sphvar.predict(points.astype(np.float32), integrand=sphvar.HealpixMap(np.ones(12), nest=True))
    sphvar.predict([[[0.0, 0.0, 1.0]]], integrand=sphvar.Energies(np.ones(4)))


def measures(points: NDArray[np.float64]) -> None:
    """Bound, audit and measure."""
    bounds = sphvar.bounds("jittered", n=48, integrand="cosine")
    assert_type(bounds.n, int)
    assert_type(bounds.worst_variance, NDArray[Any])
    sphvar.bounds(spectrum=sphvar.spectrum(points), profile="quadratic")
    sphvar.bounds(spectrum=Path("spectrum.csv"), offset="fit")
    assert_type(sphvar.audit(points).verdicts, dict[str, str])
    sphvar.audit([Path("first.csv"), Path("second.csv")], columns="ra,dec")
    assert_type(sphvar.quality(points).worst_case_error, dict[float, Any])
    sphvar.quality({"a": points, "b": "healpix"}, n=48, lmax=[2, 4], rank=True)
    lights = sphvar.lights(Path("sky.exr"), n=[16, 64], progress=print)
    assert_type(lights.directions, NDArray[np.float64])
    assert_type(sphvar.rotation_quality("all", n=[8]).power, NDArray[Any])
    assert_type(bounds.to_dict(), dict[str, Any])


def arrays(points: NDArray[np.float64]) -> None:
    """Draw, transform, integrate."""
    sets = sphvar.Sampler("poisson-disk", 64, rotate=True, seed=1).random(10)
    alm = sphvar.points2alm(sets, 10)
    assert_type(alm, NDArray[np.complex128])
    assert_type(sphvar.alm2points(alm, points, lmax=10), NDArray[np.float64])
    spectrum = sphvar.spectrum("jittered", 48, realizations=100)
    assert_type(spectrum, sphvar.Spectrum)
    assert_type(spectrum + sphvar.spectrum("jittered", 48), sphvar.Spectrum)
    assert_type(sphvar.spectrum("sobol", 64, square=True), sphvar.SquareSpectrum)
    integral = sphvar.integrate(radiance, rtol=1e-6)
    assert_type(integral, sphvar.Integral)
    assert_type(integral.nodes, NDArray[np.float64])
    assert_type(sphvar.evaluate("cosine", points), NDArray[np.float64])


def mistakes(points: NDArray[np.float64]) -> None:
    """Calls that a type checker rejects."""
    sphvar.compare(n=10, integrand="cosine", realisations=10)  # type: ignore[call-arg]
    sphvar.choose(n=10)  # type: ignore[call-arg]
    sphvar.quality(object())  # type: ignore[arg-type]
    _ = sphvar.quality(points).seperation  # type: ignore[attr-defined]
