"""Bounds, audits, quality of point sets and rotations, lights of environment maps."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, Union

import numpy as np

from . import _sphvar
from ._ask import answer, checked, warn_of, words
from ._functions import IntegrandLike
from ._given import PointsLike, given_points
from ._inputs import Inputs, SamplerLike, SamplersLike, with_defaults
from ._progress import Progress, reporting
from ._results import (
    AuditResult,
    BoundsResult,
    LightsResult,
    QualityResult,
    RotationQualityResult,
)
from ._sampler import Sampler

if TYPE_CHECKING:
    from ._spectrum import Spectrum

#: A number of points, or several: a list, a range, or a text such as ``"16..1024"``.
Counts: TypeAlias = Union[int, float, str, Sequence[int], range]

PathLike: TypeAlias = Union[str, "os.PathLike[str]"]


@checked
def bounds(
    sampler: SamplerLike | None = None,
    *,
    n: int | float | str | None = None,
    spectrum: Spectrum | PathLike | None = None,
    profile: str | None = None,
    integrand: IntegrandLike | None = None,
    nearest: bool = False,
    realizations: int | None = None,
    lmax: int | None = None,
    confidence: float | None = None,
    offset: float | str | None = None,
    band: int | None = None,
    decay: float | None = None,
    hemisphere: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> BoundsResult:
    """Bound the variance and its convergence rate by spectral profiles.

    A profile bounds the mean power spectrum from above or below. Without `profile` the tightest
    profile of each family is fitted.

    Parameters
    ----------
    sampler : str, Sampler, array of shape (n, 3) or (m, n, 3), or tuple of points and weights
        The sampler whose spectrum is bounded.
    n : int, optional
        The number of points.
    spectrum : Spectrum or path, optional
        A spectrum to bound instead of a sampler.
    profile : str, optional
        ``constant``, ``step``, ``linear``, ``quadratic`` or ``poly:b=B``, each with ``alpha=``,
        ``gamma=`` and ``offset=``. What is omitted is fitted; without a sampler and a spectrum the
        rates and bounds of the profile itself are computed.
    integrand : str, callable, array, ..., optional
        An integrand whose variance is bounded too.
    nearest : bool
        Use the valid number of points nearest to `n`.
    realizations : int, optional
        Realizations from which the spectrum is estimated: 300 by default, none where a closed form
        is available.
    lmax : int, optional
        The maximum degree, inclusive: ``4 sqrt(n)`` by default, at least 32; for lattices 10 times
        that.
    confidence : float, optional
        The confidence of fits and checks, over all degrees together: 0.99 by default.
    offset : float or "fit", optional
        The offset of the fitted profiles, a power: 0 by default.
    band : int, optional
        The band limit of the best case, a flat spectrum up to this degree: 10 by default.
    decay : float, optional
        The decay p of the worst case, energy ``l**-p``: 2 by default, for integrands with a jump.
    hemisphere : bool
        Use the hemisphere z >= 0 instead of the sphere.
    seed : int, optional
        The seed of all random numbers; that of the `Sampler` objects, otherwise 0, by default.
    progress : bool or callable, optional
        True for a bar, or a callable of the work done and expected.

    Returns
    -------
    BoundsResult
        One row a bound.

    Raises
    ------
    ValueError
        For invalid values, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> result = sphvar.bounds("jittered", n=48)
    >>> [row["best_rate"] for row in result if row["side"] == "upper"]
    ['N^-1', 'N^-1.5', 'N^-2', 'N^-1.77']
    """
    options: dict[str, Any] = {
        "count": n,
        "profile": profile,
        "nearest": nearest,
        "realizations": realizations,
        "lmax": lmax,
        "confidence": confidence,
        "offset": offset,
        "band": band,
        "decay": decay,
        "hemisphere": hemisphere,
        "seed": seed,
    }
    options = with_defaults(sampler, options)
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [sampler, spectrum, profile, integrand])
        texts = inputs.samplers(sampler)
        options["count"] = inputs.count(n)
        if integrand is not None:
            options["integrand"] = inputs.integrand(integrand)
        if isinstance(spectrum, (str, os.PathLike)):
            options["spectrum"] = os.fspath(spectrum)
        elif spectrum is not None:
            name = inputs.name("spectrum")
            power = np.asarray(spectrum.power, dtype=np.float64)
            stderr = np.asarray(spectrum.stderr, dtype=np.float64)
            session.add_spectrum(name, power, stderr, spectrum.realizations)
            options["spectrum"] = name
        return BoundsResult(inputs.relabelled(answer("bounds", texts, options, session)))


@checked
def audit(
    source: SamplerLike | PointsLike,
    n: int | float | str | None = None,
    *,
    columns: str | None = None,
    hdu: int | str | None = None,
    join: bool = False,
    skip_invalid: bool = False,
    normalize: bool = False,
    nearest: bool = False,
    realizations: int | None = None,
    lmax: int | None = None,
    alpha: float | None = None,
    tolerance: float | None = None,
    unrotated: bool = False,
    hemisphere: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> AuditResult:
    """Test an ensemble for rotation invariance, which the variance formula assumes.

    A sampler is audited as drawn and after uniform random rotations; points of shape (m, n, 3) are
    m realizations, at least 30, and audited as they are.

    Parameters
    ----------
    source : str, Sampler, array of shape (m, n, 3), tuple of points and weights, or path
        A sampler, or points, whose files are instances of `pathlib.Path`, one or a list of them.
    n : int, optional
        The number of points of a sampler.
    columns, hdu, join, skip_invalid, normalize : optional
        How files are read, as by the options of the command ``sphvar audit``.
    nearest : bool
        Use the valid number of points nearest to `n`.
    realizations : int, optional
        The number of realizations, at least 30: 2000 by default; of points each set once.
    lmax : int, optional
        The maximum degree, inclusive: 8 by default.
    alpha : float, optional
        The probability of rejecting a rotation-invariant ensemble: 0.01 by default.
    tolerance : float, optional
        The relative error of the variance that must be detectable for the verdict ``yes``: 0.2 by
        default.
    unrotated : bool
        Audit the sampler as drawn only.
    hemisphere : bool
        Use the hemisphere z >= 0 instead of the sphere.
    seed : int, optional
        The seed of all random numbers; that of the `Sampler` objects, otherwise 0, by default.
    progress : bool or callable, optional
        True for a bar, or a callable of the work done and expected.

    Returns
    -------
    AuditResult
        One row an ensemble, with its verdict.

    Raises
    ------
    ValueError
        For invalid values, in the words of the command.

    Examples
    --------
    A Fibonacci lattice is the same at each draw, so that only its rotations are invariant:

    >>> import sphvar
    >>> sphvar.audit("fibonacci", n=100, realizations=200, lmax=4).verdicts["as drawn"]
    'no'
    """
    options: dict[str, Any] = {
        "columns": columns,
        "hdu": hdu,
        "join": join,
        "skip_invalid": skip_invalid,
        "normalize": normalize,
        "nearest": nearest,
        "realizations": realizations,
        "lmax": lmax,
        "alpha": alpha,
        "tolerance": tolerance,
        "unrotated": unrotated,
        "hemisphere": hemisphere,
        "seed": seed,
    }
    options = with_defaults(source, options)
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [source, columns, hdu])
        texts: list[str] = []
        files: list[str] = []
        if isinstance(source, (str, Sampler)):
            texts = inputs.samplers(source)
            options["count"] = inputs.count(n)
        else:
            files = given_points(source, inputs)
            options["count"] = n
        question = words("audit", texts, options) + [f"--points={file}" for file in files]
        text = session.answer(question)
        warn_of(session)
        return AuditResult(inputs.relabelled(text))


@checked
def quality(
    samplers: SamplersLike,
    *,
    n: int | float | str | None = None,
    nearest: bool = False,
    realizations: int | None = None,
    lmax: int | Sequence[int] | None = None,
    rank: bool = False,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> QualityResult:
    """Measure point sets: distances, discrepancies, worst-case errors, energies, uniformity.

    Parameters
    ----------
    samplers : str, Sampler, array, tuple of points and weights, list or dict of these
        Samplers, or points of shape (n, 3) or (m, n, 3), which are measured as they are; with
        `square` (n, 2) or (m, n, 2). Keys of a dict label the rows.
    n : int, optional
        The number of points of samplers.
    nearest : bool
        Use the valid number of points nearest to `n`.
    realizations : int, optional
        The number of realizations of each sampler: 1 by default.
    lmax : int or list of int, optional
        Maximum degrees of fits of harmonics whose condition numbers are computed: a fourth and half
        of ``sqrt(n)`` by default.
    rank : bool
        Rank the set among all patterns that are not expensive at its number of points.
    hemisphere : bool
        Use the hemisphere z >= 0: all measures are those of lines through points and antipodes.
    square : bool
        Use the unit square instead of the sphere.
    seed : int, optional
        The seed of all random numbers; that of the `Sampler` objects, otherwise 0, by default.
    progress : bool or callable, optional
        True for a bar, or a callable of the work done and expected.

    Returns
    -------
    QualityResult
        Numbers for one sampler, arrays over several.

    Raises
    ------
    ValueError
        For invalid values, in the words of the command.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> octahedron = np.vstack([np.eye(3), -np.eye(3)])
    >>> measures = sphvar.quality(octahedron)
    >>> round(measures.separation, 4), measures.exact_degree
    (1.4142, 3)
    """
    options: dict[str, Any] = {
        "nearest": nearest,
        "realizations": realizations,
        "lmax": lmax,
        "rank": rank,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
    }
    options = with_defaults(samplers, options)
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [samplers], options["square"])
        texts = inputs.samplers(samplers)
        options["count"] = inputs.count(n)
        return QualityResult(inputs.relabelled(answer("quality", texts, options, session)))


@checked
def lights(
    environment: IntegrandLike | PathLike,
    n: Counts = 64,
    *,
    samplers: SamplersLike | None = None,
    nearest: bool = False,
    realizations: int | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> LightsResult:
    """Convert an environment map to n directional lights, with the error of the irradiance.

    Parameters
    ----------
    environment : str, array of shape (h, w, 3), or Environment
        The map: the path of an OpenEXR or Radiance file, ``env:FILE`` with parameters, or texels in
        linear red, green and blue, latitudes from the north in rows.
    n : int or list of int
        The number of lights, or several.
    samplers : str or list of str, optional
        ``ccvt:density=luminance`` by default, ``median-cut``, or a pattern of the unit square with
        ``warp=luminance``, such as ``sobol:warp=luminance``. ``luminance`` is the luminance of the map
        of this call; it is no density elsewhere, so `list_warps` does not have it.
    nearest : bool
        Use the valid number of points nearest to `n`.
    realizations : int, optional
        Realizations over which errors are averaged, 8 by default; the lights are of the first.
    seed : int
        The seed of all random numbers.
    progress : bool or callable, optional
        True for a bar, or a callable of the work done and expected.

    Returns
    -------
    LightsResult
        `directions` and `rgb` of the lights, and a row of errors for each sampler and number.

    Raises
    ------
    ValueError
        For invalid values, in the words of the command.
    OSError
        If a file cannot be read.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> sky = np.ones((16, 32, 3))
    >>> lights = sphvar.lights(sky, n=8)
    >>> lights.directions.shape, lights.rgb.shape
    ((8, 3), (8, 3))
    """
    options: dict[str, Any] = {
        "count": n,
        "nearest": nearest,
        "realizations": realizations,
        "seed": seed,
    }
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [environment, samplers])
        if isinstance(environment, os.PathLike):
            environment = os.fspath(environment)
        text = inputs.integrand(environment)
        if samplers is not None:
            options["samplers"] = inputs.samplers(samplers)
        return LightsResult(inputs.relabelled(answer("lights", [text], options, session)))


@checked
def rotation_quality(
    samplers: str | Sequence[str],
    n: Counts,
    *,
    nearest: bool = False,
    realizations: int | None = None,
    rotate: bool = False,
    lmax: int | None = None,
    kappa: float | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> RotationQualityResult:
    """Measure patterns of rotations: distances, exact degree, power of each degree.

    Parameters
    ----------
    samplers : str or list of str
        Patterns of rotations, as for `rotations`; ``all`` is every one.
    n : int or list of int
        The number of rotations, or several.
    nearest : bool
        Use the valid number of rotations nearest to `n`.
    realizations : int, optional
        The number of realizations: 1 by default.
    rotate : bool
        Apply an independent uniform random rotation to every realization.
    lmax : int, optional
        The maximum degree, inclusive: 4 by default.
    kappa : float, optional
        The concentration of a function on SO(3) whose mean has the error in the result.
    seed : int
        The seed of all random numbers.
    progress : bool or callable, optional
        True for a bar, or a callable of the work done and expected.

    Returns
    -------
    RotationQualityResult
        One row a pattern and number.

    Raises
    ------
    ValueError
        For invalid values, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> measures = sphvar.rotation_quality(["super-fibonacci", "uniform"], n=[64, 128])
    >>> bool((measures.separation_degrees[:2] > measures.separation_degrees[2:]).all())
    True
    """
    options: dict[str, Any] = {
        "count": n,
        "nearest": nearest,
        "realizations": realizations,
        "rotate": rotate,
        "lmax": lmax,
        "kappa": kappa,
        "seed": seed,
    }
    texts = [samplers] if isinstance(samplers, str) else list(samplers)
    for text in texts:
        if not isinstance(text, str):
            raise TypeError(
                f"samplers: expected names of patterns of rotations, got {type(text).__name__}; arrays of "
                "rotations are not measured"
            )
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [samplers])
        return RotationQualityResult(
            inputs.relabelled(answer("rotations", texts, options, session))
        )
