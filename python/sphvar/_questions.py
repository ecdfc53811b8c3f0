"""Which pattern, how many points: predictions, measurements, comparisons and rankings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeAlias, TypeVar, Union

from . import _sphvar
from ._ask import answer, checked
from ._functions import IntegrandLike
from ._inputs import Inputs, SamplersLike, with_defaults
from ._progress import Progress, reporting
from ._results import (
    ChoiceResult,
    ComparisonResult,
    ProgressiveResult,
    Result,
    Table,
    VarianceResult,
)

#: Numbers of points: one, a list or a range of them, or a text such as ``"16..1024"``, which doubles.
Counts: TypeAlias = Union[int, str, Iterable[int]]

_Result = TypeVar("_Result", bound=Result)


def _question(
    command: str,
    kind: Callable[[dict[str, Any]], _Result],
    samplers: SamplersLike | None,
    integrand: IntegrandLike | None,
    options: dict[str, Any],
    progress: Progress,
) -> _Result:
    """Ask the command about samplers and an integrand.

    Parameters
    ----------
    command
        The subcommand.
    kind
        The class of the result.
    samplers, integrand
        As the user gave them.
    options
        The other options; those that are samplers or counts too, such as ``reference``.
    progress
        As the user gave it.
    """
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        options = with_defaults(samplers, options)
        values = [samplers, integrand, *options.values()]
        inputs = Inputs(session, values, square=bool(options.get("square")))
        positional = inputs.samplers(samplers)
        options = {**options, "n": inputs.count(options.get("n"))}
        if integrand is not None:
            options["integrand"] = inputs.integrand(integrand)
        if options.get("reference") is not None:
            options["reference"] = ",".join(inputs.others(options["reference"]))
        return kind(inputs.relabelled(answer(command, positional, options, session)))


@checked
def predict(
    samplers: SamplersLike,
    *,
    n: Counts | None = None,
    integrand: IntegrandLike,
    nearest: bool = False,
    project: int | None = None,
    spectrum_realizations: int | None = None,
    lmax: int | None = None,
    kmax: int | None = None,
    method: str | None = None,
    epsilon: float | None = None,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> VarianceResult:
    """Predict the variance of integrating a function with patterns, without trials.

    The variance follows from the angular power spectrum of a pattern and that of the integrand. It is
    that of the estimate ``4 pi mean(f(x))`` (on the hemisphere ``2 pi``) over uniform rotations and
    realizations of the pattern; on the square over shifts modulo 1.

    Parameters
    ----------
    samplers
        One or several samplers: texts, `Sampler` objects, arrays of points of shape ``(n, 3)`` or
        ``(m, n, 3)``, tuples of points and weights, a list of these, or a dictionary of them by the
        labels that results show.
    n
        Number or numbers of points. Point sets have their own; the default is that of `Sampler`
        objects.
    integrand
        A text, an expression, a callable, a HEALPix map, an image or one of the wrappers.
    nearest
        Use the valid number of points nearest to each `n`.
    project
        Degree of a projection onto real spherical harmonics: a row for each coefficient, and one for
        the irradiance that they give.
    spectrum_realizations
        Realizations per estimated spectrum. Default: none where a closed form is available; otherwise
        until the prediction is known to 2 %, within a fixed amount of work.
    lmax, kmax
        Maximum degree of spectra, on the square the maximum frequency.
    method, epsilon
        Transform of point sets, ``"auto"``, ``"exact"`` or ``"fast"``, and its relative accuracy.
    hemisphere, square
        Use the hemisphere z >= 0 or the unit square instead of the sphere; the domain of the `Sampler`
        objects by default.
    seed
        Seed of all random numbers; that of the `Sampler` objects, otherwise 0, by default.
    progress
        ``True`` for a bar (tqdm), or a callable of the work done and expected.

    Returns
    -------
    VarianceResult
        A row for every sampler and number of points, with ``predicted``, ``predicted_stderr`` and the
        ends of its 95 % interval, in squared units of the integral.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    See Also
    --------
    measure : The variance over trials.
    variance : Both, and whether they agree.

    Examples
    --------
    >>> import sphvar
    >>> table = sphvar.predict("fibonacci, white-noise", n=[64, 256], integrand="vmf:kappa=4")
    >>> [row["n"] for row in table.rows]
    [64, 256, 64, 256]
    >>> float(table.predicted[0]) < 0.01 * float(table.predicted[2])
    True
    """
    options = {
        "n": n,
        "nearest": nearest,
        "project": project,
        "spectrum_realizations": spectrum_realizations,
        "lmax": lmax,
        "kmax": kmax,
        "method": method,
        "epsilon": epsilon,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
        "predict_only": True,
    }
    return _question("variance", VarianceResult, samplers, integrand, options, progress)


@checked
def measure(
    samplers: SamplersLike,
    *,
    n: Counts | None = None,
    integrand: IntegrandLike,
    realizations: int | None = None,
    until_rel: float | str | None = None,
    max_realizations: int | None = None,
    nearest: bool = False,
    project: int | None = None,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> VarianceResult:
    """Measure the variance of integrating a function with patterns over independent trials.

    Each trial is a new realization of the pattern, uniformly rotated; on the square shifted modulo 1.
    No spectrum is computed.

    Parameters
    ----------
    samplers, n, integrand, nearest, project, hemisphere, square, seed, progress
        As for `predict`.
    realizations
        Trials per variance; with `until_rel` their initial number. Default: 1000, fewer where sets
        are expensive, but at least 50.
    until_rel
        Double the trials until the relative standard error of each variance is at most this, such as
        ``0.02`` or ``"2%"``.
    max_realizations
        Maximum number of trials with `until_rel`. Default: 1000000.

    Returns
    -------
    VarianceResult
        A row for every sampler and number of points, with ``measured``, ``measured_stderr``, the ends
        of its 95 % interval, the mean estimate and the score of its bias, ``bias_z``.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    See Also
    --------
    predict : The variance from spectra, without trials.

    Examples
    --------
    >>> import numpy as np
    >>> import sphvar
    >>> corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / 3**0.5
    >>> table = sphvar.measure({"tetrahedron": corners}, integrand="cap:degrees=60", realizations=200)
    >>> table.rows[0]["sampler"], table.rows[0]["n"], table.rows[0]["trials"]
    ('tetrahedron', 4, 200)
    """
    options = {
        "n": n,
        "realizations": realizations,
        "until_rel": until_rel,
        "max_realizations": max_realizations,
        "nearest": nearest,
        "project": project,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
        "measure_only": True,
    }
    return _question("variance", VarianceResult, samplers, integrand, options, progress)


@checked
def variance(
    samplers: SamplersLike,
    *,
    n: Counts | None = None,
    integrand: IntegrandLike,
    realizations: int | None = None,
    until_rel: float | str | None = None,
    max_realizations: int | None = None,
    nearest: bool = False,
    project: int | None = None,
    spectrum_realizations: int | None = None,
    lmax: int | None = None,
    kmax: int | None = None,
    method: str | None = None,
    epsilon: float | None = None,
    visible_half: bool | str = False,
    rotations: str | None = None,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> VarianceResult:
    """Predict and measure the variance of integrating a function with patterns.

    Parameters
    ----------
    samplers, n, integrand, nearest, project, hemisphere, square, seed, progress
        As for `predict`.
    spectrum_realizations, lmax, kmax, method, epsilon
        As for `predict`.
    realizations, until_rel, max_realizations
        As for `measure`.
    visible_half
        Also measure the visible half of sphere sets of 2N points, with a random axis (``True`` or
        ``"random"``) or above the equator (``"equator"``).
    rotations
        Rotate the realizations by sets of a pattern of rotations, such as ``"super-fibonacci"``,
        instead of independently.

    Returns
    -------
    VarianceResult
        The rows of `predict` and `measure`, with ``ratio``, measured over predicted, and ``z``, their
        difference in standard errors.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> table = sphvar.variance("jittered", n=48, integrand="cap:degrees=60", realizations=200)
    >>> abs(table.rows[0]["z"]) < 5
    True
    """
    options = {
        "n": n,
        "realizations": realizations,
        "until_rel": until_rel,
        "max_realizations": max_realizations,
        "nearest": nearest,
        "project": project,
        "spectrum_realizations": spectrum_realizations,
        "lmax": lmax,
        "kmax": kmax,
        "method": method,
        "epsilon": epsilon,
        "visible_half": visible_half,
        "rotations": rotations,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
    }
    return _question("variance", VarianceResult, samplers, integrand, options, progress)


@checked
def fixed_orientation(
    samplers: SamplersLike,
    *,
    n: Counts | None = None,
    integrand: IntegrandLike,
    realizations: int | None = None,
    nearest: bool = False,
    hemisphere: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> Table:
    """Compute the errors of patterns in the orientation that they have, without rotations.

    Parameters
    ----------
    samplers, n, integrand, nearest, hemisphere, seed, progress
        As for `predict`.
    realizations
        As for `measure`.

    Returns
    -------
    Table
        A row for every sampler and number of points. For a set that is always the same: its signed
        error, with the distribution of errors over uniformly random orientations. For a random
        pattern: the mean error and the distribution over realizations.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> table = sphvar.fixed_orientation("fibonacci", n=192, integrand="ylm:l=4,m=0", realizations=200)
    >>> len(table.rows)
    1
    """
    options = {
        "n": n,
        "realizations": realizations,
        "nearest": nearest,
        "hemisphere": hemisphere,
        "seed": seed,
        "no_rotate": True,
    }
    return _question("variance", Table, samplers, integrand, options, progress)


@checked
def compare(
    samplers: SamplersLike | None = None,
    *,
    n: Counts | None = None,
    integrand: IntegrandLike | None = None,
    realizations: int | None = None,
    until_rel: float | str | None = None,
    max_realizations: int | None = None,
    project: int | None = None,
    spectrum_realizations: int | None = None,
    lmax: int | None = None,
    kmax: int | None = None,
    method: str | None = None,
    epsilon: float | None = None,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> ComparisonResult:
    """Compare patterns on an integrand: variances, their rates, and where curves cross.

    Without arguments it compares the patterns of Singh's thesis on a photographed light probe, which
    is built in, within a minute on two cores.

    Parameters
    ----------
    samplers, n, integrand
        As for `predict`. Every sampler takes its valid number of points nearest to each `n`.
    realizations, until_rel, max_realizations
        As for `measure`.
    project, spectrum_realizations, lmax, kmax, method, epsilon, hemisphere, square, seed, progress
        As for `predict`.

    Returns
    -------
    ComparisonResult
        The rows of `variance`; ``samplers``, the rate and the variance reduction of each; and
        ``crossovers``.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> compared = sphvar.compare(
    ...     {"spiral": "fibonacci", "random": "white-noise"},
    ...     n=[32, 128], integrand="cap:degrees=60", realizations=100,
    ... )
    >>> [one["sampler"] for one in compared.samplers]
    ['spiral', 'random']
    """
    options = {
        "n": n,
        "realizations": realizations,
        "until_rel": until_rel,
        "max_realizations": max_realizations,
        "project": project,
        "spectrum_realizations": spectrum_realizations,
        "lmax": lmax,
        "kmax": kmax,
        "method": method,
        "epsilon": epsilon,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
    }
    return _question("compare", ComparisonResult, samplers, integrand, options, progress)


@checked
def choose(
    samplers: SamplersLike | None = None,
    *,
    integrand: IntegrandLike,
    n: int | None = None,
    error: float | str | None = None,
    absolute: bool = False,
    max_count: int | None = None,
    cost_per_sample: float | None = None,
    project: int | None = None,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> ChoiceResult:
    """Rank patterns by the points required for an error, or by the error with n points.

    Parameters
    ----------
    samplers
        As for `predict`. Default: those for which predictions are inexpensive.
    integrand
        As for `predict`.
    n
        Sample budget; each sampler uses its largest valid count not exceeding it.
    error
        Requested standard error, relative to the integral: ``0.01`` or ``"1%"``. Either `n` or
        `error` is required.
    absolute
        Interpret `error` as an absolute error, in units of the integral.
    max_count
        Maximum number of points considered for `error`. Default: 100000.
    cost_per_sample
        Time to evaluate the integrand once, in seconds: rank by the total time.
    project, hemisphere, square, seed, progress
        As for `predict`.

    Returns
    -------
    ChoiceResult
        The samplers, the best first. Times are measured, all other numbers are reproducible.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> ranking = sphvar.choose("fibonacci, white-noise", integrand="cap:degrees=60", n=100)
    >>> ranking.best["sampler"]
    'fibonacci'
    """
    options = {
        "n": n,
        "error": error,
        "absolute": absolute,
        "max_count": max_count,
        "cost_per_sample": cost_per_sample,
        "project": project,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
    }
    return _question("choose", ChoiceResult, samplers, integrand, options, progress)


@checked
def progressive(
    samplers: SamplersLike,
    *,
    n: Counts | None = None,
    integrand: IntegrandLike,
    realizations: int | None = None,
    reference: SamplersLike | None = None,
    rotate: bool = True,
    hemisphere: bool = False,
    square: bool = False,
    seed: int | None = None,
    progress: Progress = None,
) -> ProgressiveResult:
    """Predict and measure the error of the first points of sequences, for every number of them.

    Parameters
    ----------
    samplers
        Sequences: patterns whose first N points are a set for every N, or arrays of points, which are
        sequences in their order.
    n
        One number for every prefix up to it; a list or range for those prefixes.
    integrand
        As for `predict`.
    realizations
        Trials per measured variance, at least 4. Default: 1000; fewer for samplers whose sets are
        expensive, within a fixed amount of work, but at least 50.
    reference
        Samplers with which sequences are compared at every N, or ``"none"``. Default: ``"fibonacci"``,
        on the square ``"fibonacci-lattice"``.
    rotate
        ``False`` keeps the orientation of the patterns: errors are measured only.
    hemisphere, square, seed, progress
        As for `predict`.

    Returns
    -------
    ProgressiveResult
        A row for every sequence and prefix, with ``predicted``, ``measured`` and ``factor``, the
        standard error divided by that of the reference with as many points.

    Raises
    ------
    ValueError
        For invalid samplers, counts, integrands and options, in the words of the command.

    Examples
    --------
    >>> import sphvar
    >>> prefixes = sphvar.progressive("halton", n=[16, 64], integrand="cap:degrees=60")
    >>> [row["n"] for row in prefixes.rows]
    [16, 64]
    """
    options = {
        "n": n,
        "realizations": realizations,
        "reference": reference,
        "no_rotate": not rotate,
        "hemisphere": hemisphere,
        "square": square,
        "seed": seed,
    }
    return _question("progressive", ProgressiveResult, samplers, integrand, options, progress)
