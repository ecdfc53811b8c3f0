"""Results: what a question answers, with the numbers as attributes and arrays."""

from __future__ import annotations

import copy
import difflib
import html
import importlib
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, overload

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Row = dict[str, Any]

#: Rows that a table shows before it states how many there are.
_SHOWN_ROWS = 20

#: What differs between two runs of the same question.
_NOT_COMPARED = ("provenance", "seconds", "seconds_per_set", "seconds_in_all")


class Result:
    """An answer: the numbers of a document, as attributes.

    The document is the one that the command prints with ``--json``. Numbers that cannot be given
    are ``None``. Two results are equal if their documents are, apart from times and provenance.

    Attributes
    ----------
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    #: Keys that ``repr`` shows.
    _shown: ClassVar[tuple[str, ...]] = ()

    provenance: dict[str, Any]

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._document = dict(document)

    def to_dict(self) -> dict[str, Any]:
        """Return the document of ``sphvar COMMAND --json``, as a copy.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.bounds(profile="quadratic:alpha=0.5,gamma=1", n=64).to_dict()["n"]
        64
        """
        return copy.deepcopy(self._document)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            kind = type(self).__name__
            # Protocols such as pickling look for names with underscores, also before there is a
            # document.
            if name.startswith("_"):
                raise AttributeError(f"{kind} has no attribute {name!r}")
            found = self._attribute(name)
            if found is not NotImplemented:
                return found
            close = difflib.get_close_matches(name, self._names(), 3)
            hint = f"; did you mean {' or '.join(close)}?" if close else ""
            raise AttributeError(f"{kind} has no attribute {name!r}{hint}")

    def _attribute(self, name: str) -> Any:
        return self._document.get(name, NotImplemented)

    def _names(self) -> list[str]:
        return list(self._document)

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._names()})

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return bool(_compared(self._document) == _compared(other._document))

    __hash__ = None  # type: ignore[assignment]

    def _lines(self) -> list[tuple[str, str]]:
        keys = self._shown or tuple(self._document)
        keys = tuple(key for key in keys if key in self._document)
        return [(key, _text(self._document[key], self._document.get(_error_of(key)))) for key in keys]

    def __repr__(self) -> str:
        lines = self._lines()
        width = max((len(name) for name, _ in lines), default=0)
        return "\n".join([type(self).__name__, *(f"  {k:<{width}}  {v}" for k, v in lines)])

    def _repr_html_(self) -> str:
        lines = self._lines()
        rows = (f"<tr><th>{html.escape(k)}</th><td>{html.escape(v)}</td></tr>" for k, v in lines)
        return f"<table>{''.join(rows)}</table>"


class Table(Result, Sequence[Row]):
    """An answer with rows: a sequence of them, and their columns as arrays.

    Columns are attributes and items: ``table.n`` and ``table["n"]`` are numpy arrays with one entry a row, in
    which numbers that cannot be given are NaN.

    Attributes
    ----------
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    #: The key of the rows in the document.
    _rows_key: ClassVar[str] = "rows"

    #: Headings and keys of the columns that ``repr`` shows.
    _shown_columns: ClassVar[tuple[tuple[str, str], ...]] = ()

    @property
    def rows(self) -> list[Row]:
        """The rows, each a dict with the keys of the document.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.quality("fibonacci", n=100).rows[0]["sampler"]
        'fibonacci'
        """
        rows: list[Row] = self._document.get(self._rows_key) or []
        return rows

    @property
    def columns(self) -> list[str]:
        """The names of the columns.

        Examples
        --------
        >>> import sphvar
        >>> "best_rate" in sphvar.bounds("healpix", n=48).columns
        True
        """
        return list(dict.fromkeys(key for row in self.rows for key in row))

    def column(self, name: str) -> NDArray[Any]:
        """Return a column as an array with one entry a row.

        Parameters
        ----------
        name : str
            One of `columns`.

        Returns
        -------
        numpy.ndarray
            Integers, floats with NaN for numbers that cannot be given, or strings; objects where
            entries have parts. Lists of numbers of equal length are the rows of a matrix.

        Raises
        ------
        KeyError
            If no row has this key.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.quality(["fibonacci", "healpix"], n=48).column("n")
        array([48, 48])
        """
        rows = self.rows
        if not any(name in row for row in rows):
            raise KeyError(name)
        return _array([row.get(name) for row in rows])

    def to_pandas(self) -> Any:
        """Return the rows as a `pandas.DataFrame`, if pandas is installed.

        Raises
        ------
        ImportError
            Without pandas.

        Examples
        --------
        >>> import sphvar
        >>> table = sphvar.quality(["fibonacci", "healpix"], n=48)
        >>> table.to_pandas().shape[0]  # doctest: +SKIP
        2
        """
        try:
            pandas = importlib.import_module("pandas")
        except ImportError as error:
            raise ImportError("to_pandas needs pandas: pip install pandas") from error
        return pandas.DataFrame(self.rows)

    def _attribute(self, name: str) -> Any:
        if name in self._document:
            return self._document[name]
        try:
            return self.column(name)
        except KeyError:
            return NotImplemented

    def _names(self) -> list[str]:
        return [*self._document, *self.columns]

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    @overload
    def __getitem__(self, index: int) -> Row: ...

    @overload
    def __getitem__(self, index: slice) -> list[Row]: ...

    @overload
    def __getitem__(self, index: str) -> NDArray[Any]: ...

    def __getitem__(self, index: int | slice | str) -> Row | list[Row] | NDArray[Any]:
        return self.column(index) if isinstance(index, str) else self.rows[index]

    def _cells(self) -> tuple[list[str], list[list[str]], int]:
        """Return headings, the cells of the shown rows, and the number of the other rows."""
        shown = self._shown_columns or tuple((key, key) for key in self.columns)
        shown = tuple((title, k) for title, k in shown if any(r.get(k) is not None for r in self))
        cells = [[_text(row.get(key)) for _, key in shown] for row in self.rows[:_SHOWN_ROWS]]
        return [title for title, _ in shown], cells, max(0, len(self) - _SHOWN_ROWS)

    def _notes(self) -> list[str]:
        """Return sentences below the table."""
        return []

    def __repr__(self) -> str:
        titles, cells, left = self._cells()
        lines = _aligned([titles, *cells]) if titles else [f"{type(self).__name__} without rows"]
        if left:
            lines.append(f"and {left} more rows")
        return "\n".join([*lines, *self._notes()])

    def _repr_html_(self) -> str:
        titles, cells, left = self._cells()
        head = "".join(f"<th>{html.escape(title)}</th>" for title in titles)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>"
            for row in cells
        )
        notes = [f"and {left} more rows"] if left else []
        paragraphs = "".join(f"<p>{html.escape(note)}</p>" for note in [*notes, *self._notes()])
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>{paragraphs}"


class VarianceResult(Table):
    """Predicted and measured variances: one row a sampler and number of points.

    Attributes
    ----------
    sampler : numpy.ndarray of str
        The samplers.
    integrand : numpy.ndarray of str
        The integrand.
    domain : numpy.ndarray of str
        ``sphere``, ``hemisphere`` or ``square``.
    n_requested, n : numpy.ndarray of int
        The numbers of points that were requested and used.
    lmax : numpy.ndarray of int
        The largest degree of the spectrum.
    realizations, trials : numpy.ndarray of int
        Realizations from which the spectrum was estimated, 0 for a closed form, and trials from
        which the variance was measured.
    predicted, predicted_stderr : numpy.ndarray
        The predicted variance of the integral and its standard error.
    predicted_low, predicted_high : numpy.ndarray
        The 95 % interval of the predicted variance.
    predicted_tail, predicted_tail_error : numpy.ndarray
        The part of the predicted variance beyond the largest degree, and the error of that.
    measured, measured_stderr : numpy.ndarray
        The measured variance and its standard error.
    measured_low, measured_high : numpy.ndarray
        The 95 % interval of the measured variance.
    ratio, ratio_stderr : numpy.ndarray
        Measured over predicted variance, and its standard error.
    z : numpy.ndarray
        Measured minus predicted variance, in standard errors.
    mean, mean_stderr : numpy.ndarray
        The mean estimate over the trials and its standard error.
    exact : numpy.ndarray
        The exact integral, if it is known.
    relative_error : numpy.ndarray
        The predicted standard error over the exact integral.
    bias_z, bias_p : numpy.ndarray
        Mean minus exact integral in standard errors, and the probability of one of this size
        without a bias.
    n_effective : numpy.ndarray
        The effective number of weighted points; NaN without weights.
    remark : numpy.ndarray
        Why numbers are missing.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown_columns = (
        ("sampler", "sampler"),
        ("N", "n"),
        ("predicted", "predicted"),
        ("+-", "predicted_stderr"),
        ("measured", "measured"),
        ("+-", "measured_stderr"),
        ("ratio", "ratio"),
        ("z", "z"),
    )

    sampler: NDArray[Any]
    integrand: NDArray[Any]
    domain: NDArray[Any]
    n_requested: NDArray[Any]
    n: NDArray[Any]
    lmax: NDArray[Any]
    realizations: NDArray[Any]
    trials: NDArray[Any]
    predicted: NDArray[Any]
    predicted_stderr: NDArray[Any]
    predicted_low: NDArray[Any]
    predicted_high: NDArray[Any]
    predicted_tail: NDArray[Any]
    predicted_tail_error: NDArray[Any]
    measured: NDArray[Any]
    measured_stderr: NDArray[Any]
    measured_low: NDArray[Any]
    measured_high: NDArray[Any]
    ratio: NDArray[Any]
    ratio_stderr: NDArray[Any]
    z: NDArray[Any]
    mean: NDArray[Any]
    mean_stderr: NDArray[Any]
    exact: NDArray[Any]
    relative_error: NDArray[Any]
    bias_z: NDArray[Any]
    bias_p: NDArray[Any]
    n_effective: NDArray[Any]
    remark: NDArray[Any]

    @property
    def best(self) -> Row | None:
        """The row of least variance at the largest number of points, predicted if that is known.

        Examples
        --------
        >>> import sphvar
        >>> table = sphvar.predict(["white-noise", "fibonacci"], n=48, integrand="cosine")
        >>> table.best["sampler"]
        'fibonacci'
        """
        last: dict[str, Row] = {}
        for row in self.rows:
            before = last.get(row["sampler"])
            if before is None or row["n"] >= before["n"]:
                last[row["sampler"]] = row
        known = [(_variance(row), i) for i, row in enumerate(last.values())]
        known = [(variance, i) for variance, i in known if variance is not None]
        return list(last.values())[min(known)[1]] if known else None

    def plot(self, ax: Axes | None = None, *, standard_errors: bool = False) -> Axes:
        """Plot the variance against the number of points, both on logarithmic axes.

        Lines are predicted, markers measured, with their 95 % intervals.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.
        standard_errors : bool
            Plot standard errors, the square roots, instead of variances.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> table = sphvar.predict("fibonacci", n=[12, 48, 192], integrand="cap:degrees=60")
        >>> table.plot().get_xlabel()
        'number of points N'
        """
        from . import _plots

        return _plots.variances(ax, self, standard_errors)

    def _rates(self) -> dict[str, float]:
        """Return the exponents b of the variance as N^b, where they are known."""
        return {}

    def _notes(self) -> list[str]:
        # The rows of a table that are shown, by the remark that they have.
        found: dict[str, list[str]] = {}
        for row in self.rows[:_SHOWN_ROWS]:
            if row.get("remark"):
                found.setdefault(row["remark"], []).append(f"{row['sampler']} N = {row['n']}")
        return [f"{', '.join(rows)}: {remark}" for remark, rows in found.items()]


class ComparisonResult(VarianceResult):
    """A comparison: the rows of `VarianceResult`, with rates and crossovers.

    Attributes
    ----------
    samplers : list of dict
        Every sampler over all its numbers of points: the exponent ``rate`` of the variance as
        ``N**rate``, its ``rate_interval``, the ``variance_reduction`` against white noise, ...
    crossovers : list of dict
        Significant crossings of variance curves: ``better_below``, ``better_above``, ``n``, ...
    """

    samplers: list[Row]
    crossovers: list[Row]

    def _rates(self) -> dict[str, float]:
        return {s["sampler"]: s["rate"] for s in self.samplers if s.get("rate") is not None}

    def _notes(self) -> list[str]:
        rates = self._rates()
        if not rates:
            return super()._notes()
        return [*super()._notes(), "rates: " + ", ".join(f"{name} N^{rate:.2f}" for name, rate in rates.items())]


class ChoiceResult(Table):
    """Samplers for an integrand, the best first.

    Attributes
    ----------
    integral : float or None
        The integral, exact or accurate to 0.1 %.
    recommendation : str
        The recommendation with its reason, in a sentence.
    reason, density_benefit : dict or None
        The reason in numbers, and what densities that resemble the integrand buy.
    white_noise_points : float or None
        The number of points that white noise needs for the error requested.
    left_out : list of dict
        Samplers that were not considered, each with the reason.
    crossovers : list of dict
        Crossings of the variance curves of the best samplers.
    error_requested, points_requested, max_points, cost_per_sample : float or None
        The question.
    domain : str
        ``sphere``, ``hemisphere`` or ``square``.
    rank : numpy.ndarray of int
        The place, from 1 for the best.
    sampler : numpy.ndarray of str
        The samplers, as every function accepts them.
    integrand : str
        The integrand, as it was given.
    n : numpy.ndarray
        The number of points needed, or the largest valid count within the budget.
    basis : numpy.ndarray of str
        How ``n`` or the error is known: ``predicted``, ``extrapolated``, ``out of reach``, ...
    too_few : numpy.ndarray
        The largest number of points tried that does not suffice.
    variance, variance_stderr, variance_tail_error : numpy.ndarray
        The predicted variance of the integral, its standard error, and the largest error from
        degrees beyond the spectrum.
    error, relative_error : numpy.ndarray
        The standard error, and the same over the integral.
    variance_reduction : numpy.ndarray
        The variance of white noise with the same number of points, divided by this one.
    rate, rate_interval : numpy.ndarray
        The exponent b of the variance as ``N**b`` near ``n``, and its 95 % interval.
    seconds_per_set, seconds_are_scaled, seconds_in_all : numpy.ndarray
        The time to make a set, whether it is scaled from a smaller set, and the time for a set
        and all values.
    lmax, realizations, last_empty_degree, n_effective : numpy.ndarray
        The largest degree of the spectrum, realizations from which it was estimated, the degree
        up to which the pattern has no power, and the effective number of weighted points.
    curve : numpy.ndarray of object
        Every prediction that was made: lists of dicts with ``n`` and ``variance``.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown_columns = (
        ("rank", "rank"),
        ("sampler", "sampler"),
        ("N", "n"),
        ("error", "error"),
        ("relative", "relative_error"),
        ("reduction", "variance_reduction"),
        ("rate", "rate"),
        ("basis", "basis"),
    )

    integral: float | None
    recommendation: str
    reason: Row | None
    density_benefit: Row | None
    white_noise_points: float | None
    left_out: list[Row]
    crossovers: list[Row]
    error_requested: float | None
    points_requested: int | None
    max_points: int | None
    cost_per_sample: float | None
    domain: str
    integrand: str
    rank: NDArray[Any]
    sampler: NDArray[Any]
    n: NDArray[Any]
    basis: NDArray[Any]
    too_few: NDArray[Any]
    variance: NDArray[Any]
    variance_stderr: NDArray[Any]
    variance_tail_error: NDArray[Any]
    error: NDArray[Any]
    relative_error: NDArray[Any]
    variance_reduction: NDArray[Any]
    rate: NDArray[Any]
    rate_interval: NDArray[Any]
    seconds_per_set: NDArray[Any]
    seconds_are_scaled: NDArray[Any]
    seconds_in_all: NDArray[Any]
    lmax: NDArray[Any]
    realizations: NDArray[Any]
    last_empty_degree: NDArray[Any]
    n_effective: NDArray[Any]
    curve: NDArray[Any]

    @property
    def best(self) -> Row:
        """The recommended row; the first one if no sampler is recommended.

        Ranks are those of errors. The recommended row may be another one: a less expensive sampler within
        10 % of it, or a sampler behind one whose density is the integrand itself, of which the integral
        is known without samples.

        Examples
        --------
        >>> import sphvar
        >>> choice = sphvar.choose(["white-noise", "fibonacci"], integrand="cosine", n=48)
        >>> choice.best["sampler"]
        'fibonacci'
        """
        for row in self.rows:
            text = f"Recommended: {row['sampler']} with N = {row['n']} "
            if self.recommendation.startswith(text):
                return row
        return self.rows[0]

    def _notes(self) -> list[str]:
        left_out = [f"Left out: {one['sampler']} ({one['reason']})." for one in self.left_out or []]
        return [self.recommendation, *left_out]

    def plot(self, ax: Axes | None = None, *, best: int = 8) -> Axes:
        """Plot the predicted standard errors of the best samplers against the number of points.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.
        best : int
            The number of samplers.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> choice = sphvar.choose(["white-noise", "fibonacci"], integrand="cosine", n=48)
        >>> choice.plot().get_ylabel()
        'standard error'
        """
        from . import _plots

        return _plots.choice(ax, self, best)


class ProgressiveResult(Table):
    """Predicted and measured variances of the prefixes of sequences.

    Attributes
    ----------
    sequences : list of dict
        Every sequence over all its prefixes: ``rate``, ``mean_factor``, ``worst_factor``, ...
    reference : list of dict
        The patterns with which sequences are compared, made for each of some numbers of points.
    sampler, integrand : numpy.ndarray of str
        The sequence and the integrand.
    n : numpy.ndarray of int
        The number of points of the prefix.
    predicted, predicted_stderr, predicted_tail_error : numpy.ndarray
        The predicted variance, its standard error, and its error due to degrees beyond the
        spectrum.
    measured, measured_stderr, measured_low, measured_high : numpy.ndarray
        The measured variance, its standard error and its 95 % interval.
    z : numpy.ndarray
        Measured minus predicted variance, in standard errors.
    mean, mean_stderr : numpy.ndarray
        The mean estimate of the integral over the trials.
    factor : numpy.ndarray
        The standard error divided by that of the reference with as many points, or the most below
        that it has.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown_columns = (
        ("sampler", "sampler"),
        ("N", "n"),
        ("predicted", "predicted"),
        ("+-", "predicted_stderr"),
        ("measured", "measured"),
        ("+-", "measured_stderr"),
        ("z", "z"),
        ("factor", "factor"),
    )

    sequences: list[Row]
    reference: list[Row]
    sampler: NDArray[Any]
    integrand: NDArray[Any]
    n: NDArray[Any]
    predicted: NDArray[Any]
    predicted_stderr: NDArray[Any]
    predicted_tail_error: NDArray[Any]
    measured: NDArray[Any]
    measured_stderr: NDArray[Any]
    measured_low: NDArray[Any]
    measured_high: NDArray[Any]
    z: NDArray[Any]
    mean: NDArray[Any]
    mean_stderr: NDArray[Any]
    factor: NDArray[Any]

    @property
    def best(self) -> Row | None:
        """The sequence of the least mean factor, one of `sequences`, if any has one.

        Examples
        --------
        >>> import sphvar
        >>> result = sphvar.progressive(
        ...     ["white-noise", "sobol"], n=[16, 64], integrand="cosine", realizations=50
        ... )
        >>> result.best["sampler"]
        'sobol'
        """
        known = [s for s in self.sequences if s.get("mean_factor") is not None]
        return min(known, key=lambda s: float(s["mean_factor"]), default=None)

    def plot(self, ax: Axes | None = None, *, factors: bool = False) -> Axes:
        """Plot the standard error of every prefix, or its factor, against the number of points.

        Lines are predicted, markers measured, with their 95 % intervals.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.
        factors : bool
            Plot the factors over the reference instead of standard errors.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> result = sphvar.progressive(
        ...     "sobol", n=[16, 64], integrand="cosine", realizations=50
        ... )
        >>> result.plot(factors=True).get_ylabel()
        'standard error / fibonacci'
        """
        from . import _plots

        return _plots.progression(ax, self, factors)


class BoundsResult(Table):
    """Profiles that bound a spectrum, and the variances and rates that follow from them.

    Attributes
    ----------
    n : int
        The number of points.
    domain : str
        ``sphere`` or ``hemisphere``.
    confidence : float
        The confidence of fits and checks, over all degrees together.
    lmax : int or None
        The largest degree of the spectrum.
    none : list of dict
        Families without a bound, each with the reason.
    thesis : list of dict
        The bounds that Singh's thesis gives for the sampler, checked.
    side : numpy.ndarray of str
        ``upper``, ``lower``, or ``given`` without a spectrum.
    origin : numpy.ndarray of str
        The origin: ``given``, ``checked``, ``fitted``, ...
    family : numpy.ndarray of str
        ``constant``, ``step``, ``linear``, ``quadratic`` or ``poly``.
    exponent, alpha, gamma, offset : numpy.ndarray
        The profile: ``offset + gamma * min(1, omega / alpha)**exponent`` with
        ``omega = l / sqrt(n)``; NaN for the exponent of a step, which is 0 below ``alpha``.
    holds : numpy.ndarray
        Whether the spectrum is within the bound; None without a spectrum.
    worst_degree, worst_ratio : numpy.ndarray
        The degree that speaks most against the bound, and power over bound there.
    touching : numpy.ndarray of object
        The degrees at which the profile meets the confidence limits.
    gap : numpy.ndarray
        The share by which the best profile of the family can be better at most.
    best_rate, worst_rate : numpy.ndarray of str
        The convergence rates for the best case, a band-limited integrand, and for the worst case,
        energies that fall as a power of the degree.
    best_variance, worst_variance : numpy.ndarray
        The variances for these cases.
    integrand_variance : numpy.ndarray
        The range of the variance of the integrand under the profile.
    integrand_bound : numpy.ndarray
        The end of it on the side of the bound.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _rows_key = "bounds"
    _shown_columns = (
        ("side", "side"),
        ("profile", "family"),
        ("b", "exponent"),
        ("alpha", "alpha"),
        ("gamma", "gamma"),
        ("offset", "offset"),
        ("holds", "holds"),
        ("best rate", "best_rate"),
        ("variance", "best_variance"),
        ("worst rate", "worst_rate"),
        ("variance", "worst_variance"),
        ("integrand", "integrand_bound"),
    )

    n: int
    domain: str
    confidence: float
    lmax: int | None
    none: list[Row]
    thesis: list[Row]
    side: NDArray[Any]
    origin: NDArray[Any]
    family: NDArray[Any]
    exponent: NDArray[Any]
    alpha: NDArray[Any]
    gamma: NDArray[Any]
    offset: NDArray[Any]
    holds: NDArray[Any]
    worst_degree: NDArray[Any]
    worst_ratio: NDArray[Any]
    touching: NDArray[Any]
    gap: NDArray[Any]
    best_rate: NDArray[Any]
    worst_rate: NDArray[Any]
    best_variance: NDArray[Any]
    worst_variance: NDArray[Any]
    integrand_variance: NDArray[Any]
    integrand_bound: NDArray[Any]

    def _notes(self) -> list[str]:
        return [f"no {row['side']} {row['family']}: {row['reason']}" for row in self.none]

    def plot(self, ax: Axes | None = None, *, spectrum: Any = None) -> Axes:
        """Plot the profiles against ``omega = l / sqrt(n)``; upper ones solid, lower ones dashed.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.
        spectrum : Spectrum, optional
            A spectrum to plot with them, such as the one that they bound.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.bounds("healpix", n=48).plot().get_ylabel()
        'power P(l)'
        """
        from . import _plots

        return _plots.bounds(ax, self, spectrum)


class AuditResult(Table):
    """Tests of an ensemble for rotation invariance: one row an ensemble.

    Attributes
    ----------
    n, realizations, lmax, copies : int
        The number of points, of realizations, the largest degree, and the number of randomly
        rotated copies that tests compare with.
    alpha, tolerance : float
        The probability that a rotation-invariant ensemble is rejected, and the relative error of
        a variance that must be detectable for the verdict ``yes``.
    domain : str
        ``sphere`` or ``hemisphere``.
    sampler : str
        The sampler with its parameters, or the points.
    ensemble : numpy.ndarray of str
        ``as drawn``, ``rotated`` or ``from files``.
    verdict : numpy.ndarray of str
        Whether the variance formula is valid: ``yes``, ``no`` or ``undecided``.
    conclusion : numpy.ndarray of str
        The conclusion from the tests, in sentences.
    detectable : numpy.ndarray
        The relative error of a variance that 9 of 10 audits would detect.
    vanishing, tests, ratios, bias : numpy.ndarray of object
        Degrees without power; the tests, with their ``p_value``; mean squared errors of the
        integrals of single harmonics over the predicted variances; the largest bias.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _rows_key = "audits"
    _shown_columns = (
        ("ensemble", "ensemble"),
        ("verdict", "verdict"),
        ("detectable", "detectable"),
    )

    n: int
    realizations: int
    lmax: int
    copies: int
    alpha: float
    tolerance: float
    domain: str
    sampler: str
    ensemble: NDArray[Any]
    verdict: NDArray[Any]
    conclusion: NDArray[Any]
    detectable: NDArray[Any]
    vanishing: NDArray[Any]
    tests: NDArray[Any]
    ratios: NDArray[Any]
    bias: NDArray[Any]

    @property
    def verdicts(self) -> dict[str, str]:
        """Whether the variance formula is valid, by ensemble: ``yes``, ``no`` or ``undecided``.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.audit("fibonacci", n=100, realizations=200, lmax=4).verdicts["as drawn"]
        'no'
        """
        return {row["ensemble"]: row["verdict"] for row in self.rows}

    def _cells(self) -> tuple[list[str], list[list[str]], int]:
        titles, cells, left = super()._cells()
        names = list(dict.fromkeys(test["test"] for row in self.rows for test in row["tests"]))
        for row, line in zip(self.rows, cells):
            p_values = {test["test"]: test["p_value"] for test in row["tests"]}
            line.extend(_text(p_values.get(name)) for name in names)
        return [*titles, *(f"p({name})" for name in names)], cells, left

    def _notes(self) -> list[str]:
        return [f"{row['ensemble']}: {row['conclusion']}" for row in self.rows]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the mean squared error of every harmonic over the predicted variance.

        Bars are intervals that hold for all degrees and orders together.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.audit("jittered", n=48, realizations=100, lmax=2).plot().get_ylabel()
        'mean squared error / variance formula'
        """
        from . import _plots

        return _plots.audit(ax, self)


class QualityResult(Table):
    """Measures of point sets: numbers for one sampler or set, arrays over several.

    Measures that depend on an exponent or a degree are dicts from it to the number or array.

    Attributes
    ----------
    sampler, domain : str or numpy.ndarray of str
        The sampler or points, and ``sphere``, ``hemisphere`` or ``square``.
    n, n_effective, realizations : int, float or numpy.ndarray
        The number of points, the effective number of weighted points, and of realizations.
    separation : float or numpy.ndarray
        The least chord between two points; on the square the least toroidal distance.
    covering_radius, mesh_ratio : float or numpy.ndarray
        The largest chord from a direction to its nearest point; twice that over the separation.
    cap_discrepancy_l2, generalized_discrepancy : float or numpy.ndarray
        The L2 spherical cap discrepancy, and the generalized discrepancy of Cui and Freeden.
    worst_case_error : dict
        The worst-case error of the mean in the Sobolev space H^s, by s.
    riesz_energy : dict
        The Riesz energy over unordered pairs, by s.
    exact_degree : int or numpy.ndarray
        The largest degree to which all harmonics are integrated exactly.
    condition : dict
        The condition number of the fit of harmonics, by degree.
    hyperuniformity, p_value, rank, stderr, scaled : dict or numpy.ndarray of object
        How the power falls toward low degrees; the test of independent uniform points; the place
        among patterns; standard errors of means; values that are comparable between N.
    relative_separation : float or numpy.ndarray
        On the square: the separation relative to that of a hexagonal lattice.
    star_discrepancy, l2_star_discrepancy, wraparound_l2_discrepancy : float or numpy.ndarray
        On the square: the star discrepancy, and those of Warnock and Hickernell.
    net_t : int or numpy.ndarray
        On the square: the least t for which each set is a (t, m, 2)-net in base 2.
    remarks : list of str or numpy.ndarray of object
        Why numbers are missing.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown_columns = (
        ("sampler", "sampler"),
        ("N", "n"),
        ("separation", "separation"),
        ("covering", "covering_radius"),
        ("mesh ratio", "mesh_ratio"),
        ("cap discrepancy", "cap_discrepancy_l2"),
        ("exact degree", "exact_degree"),
        ("star discrepancy", "star_discrepancy"),
        ("L2 star", "l2_star_discrepancy"),
        ("wraparound", "wraparound_l2_discrepancy"),
        ("t", "net_t"),
    )

    sampler: Any
    domain: Any
    n: Any
    n_effective: Any
    realizations: Any
    separation: Any
    covering_radius: Any
    mesh_ratio: Any
    cap_discrepancy_l2: Any
    generalized_discrepancy: Any
    worst_case_error: dict[float, Any]
    riesz_energy: dict[float, Any]
    exact_degree: Any
    condition: dict[float, Any]
    hyperuniformity: Any
    p_value: Any
    rank: Any
    stderr: Any
    scaled: Any
    relative_separation: Any
    star_discrepancy: Any
    l2_star_discrepancy: Any
    wraparound_l2_discrepancy: Any
    net_t: Any
    remarks: Any

    @property
    def rows(self) -> list[Row]:
        """The measures of each sampler or point set, each a dict with the keys of the document.

        Examples
        --------
        >>> import sphvar
        >>> len(sphvar.quality(["fibonacci", "healpix"], n=48).rows)
        2
        """
        # The document of a single sampler has its measures at the top.
        rows: list[Row] | None = self._document.get("rows")
        return [self._only()] if rows is None else rows

    def _only(self) -> Row:
        return {key: value for key, value in self._document.items() if key != "provenance"}

    def _attribute(self, name: str) -> Any:
        if name == "provenance":
            return self._document[name]
        if not any(name in row for row in self.rows):
            return NotImplemented
        entries = [row.get(name) for row in self.rows]
        if name in ("scaled", "stderr"):
            entries = [_with_numbers(entry) for entry in entries]
            return _array(entries) if "rows" in self._document else entries[0]
        if name in _BY_NUMBER:
            keys = dict.fromkeys(key for entry in entries for key in entry or {})
            if "rows" not in self._document:
                return {_number(key): (entries[0] or {})[key] for key in keys}
            return {_number(key): _array([(e or {}).get(key) for e in entries]) for key in keys}
        return self.column(name) if "rows" in self._document else entries[0]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot distances, discrepancies and worst-case errors; smaller is better.

        On the sphere and the hemisphere values are scaled by powers of N, so that sets of
        different sizes are comparable.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.quality(["fibonacci", "healpix"], n=48).plot().get_ylabel()
        'measure, scaled by a power of N'
        """
        from . import _plots

        return _plots.quality(ax, self)


class LightsResult(Table):
    """Directional lights of an environment map, and the error of their irradiance.

    The rows are the errors of every sampler and number of lights.

    Attributes
    ----------
    environment, axes, colours : str
        The map, the frame of directions, and the unit of colours.
    irradiance_error : float or None
        The error of the irradiance over all normals, of the luminance, relative to its root mean
        square, of the lights in `directions`; None for several samplers or numbers.
    sampler : numpy.ndarray of str
        The samplers.
    n, realizations : numpy.ndarray of int
        The number of lights and of realizations.
    error, error_stderr : numpy.ndarray
        The error of the luminance and its standard error.
    red, green, blue : numpy.ndarray
        The errors of the channels.
    seconds : numpy.ndarray
        The mean time to compute the lights.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _rows_key = "irradiance_errors"
    _shown_columns = (
        ("sampler", "sampler"),
        ("N", "n"),
        ("error", "error"),
        ("+-", "error_stderr"),
        ("red", "red"),
        ("green", "green"),
        ("blue", "blue"),
    )

    environment: str
    axes: str
    colours: str
    irradiance_error: float | None
    sampler: NDArray[Any]
    n: NDArray[Any]
    realizations: NDArray[Any]
    error: NDArray[Any]
    error_stderr: NDArray[Any]
    red: NDArray[Any]
    green: NDArray[Any]
    blue: NDArray[Any]
    seconds: NDArray[Any]

    @property
    def directions(self) -> NDArray[np.float64]:
        """The unit vectors towards the lights, of shape (n, 3).

        Raises
        ------
        ValueError
            If the question was about several samplers or numbers of lights.

        Examples
        --------
        >>> import numpy as np, sphvar
        >>> sphvar.lights(np.ones((8, 16, 3)), n=4).directions.shape
        (4, 3)
        """
        return self._lights("xyz")

    @property
    def rgb(self) -> NDArray[np.float64]:
        """The irradiance of a surface that faces each light, of shape (n, 3).

        Raises
        ------
        ValueError
            If the question was about several samplers or numbers of lights.

        Examples
        --------
        The lights of a white sky carry ``4 pi`` together, whatever their number:

        >>> import numpy as np, sphvar
        >>> lights = sphvar.lights(np.ones((8, 16, 3)), n=4)
        >>> bool(np.allclose(lights.rgb.sum(axis=0), 4 * np.pi))
        True
        """
        return self._lights("rgb")

    def _lights(self, keys: str) -> NDArray[np.float64]:
        lights = self._document["rows"]
        if lights is None:
            raise ValueError("lights are listed for a single sampler and number of lights only")
        flat = [light[key] for light in lights for key in keys]
        return np.array(flat, dtype=np.float64).reshape(-1, 3)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the lights by longitude and latitude, in their colours, with areas by luminance.

        Several samplers or numbers of lights are plotted as errors against the number.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import numpy as np, sphvar
        >>> sphvar.lights(np.ones((8, 16, 3)), n=4).plot().get_xlabel()
        'longitude (degrees)'
        """
        from . import _plots

        return _plots.lights(ax, self)


class RotationQualityResult(Table):
    """Measures of sets of rotations: one row a pattern and number.

    Attributes
    ----------
    sampler : numpy.ndarray of str
        The patterns.
    n, realizations, exact_degree : numpy.ndarray of int
        The number of rotations, of realizations that were measured, and the largest degree up to
        which all functions have their means over SO(3).
    n_effective : numpy.ndarray
        The number of rotations of equal weight with the same noise.
    separation_degrees, covering_radius_degrees : numpy.ndarray
        The least angle between two rotations, and the largest from any to its nearest one.
    power, power_stderr : numpy.ndarray
        The power of each degree, from 0, one row a pattern, and its standard errors.
    kappa, error, error_stderr, error_of_uniform : numpy.ndarray
        With `kappa`: the concentration of the function, the error of its mean, the standard error
        of that, and the expected error of independent rotations.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown_columns = (
        ("sampler", "sampler"),
        ("N", "n"),
        ("separation", "separation_degrees"),
        ("covering", "covering_radius_degrees"),
        ("exact degree", "exact_degree"),
        ("error", "error"),
        ("+-", "error_stderr"),
        ("uniform", "error_of_uniform"),
    )

    sampler: NDArray[Any]
    n: NDArray[Any]
    realizations: NDArray[Any]
    exact_degree: NDArray[Any]
    n_effective: NDArray[Any]
    separation_degrees: NDArray[Any]
    covering_radius_degrees: NDArray[Any]
    power: NDArray[Any]
    power_stderr: NDArray[Any]
    kappa: NDArray[Any]
    error: NDArray[Any]
    error_stderr: NDArray[Any]
    error_of_uniform: NDArray[Any]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the power of each degree.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.rotation_quality("super-fibonacci", n=64).plot().get_xlabel()
        'degree l'
        """
        from . import _plots

        return _plots.rotations(ax, self)


def _variance(row: Row) -> float | None:
    predicted = row.get("predicted")
    return row.get("measured") if predicted is None else predicted


def _compared(value: Any) -> Any:
    """Return a document without what differs between two runs of the same question.

    NaN, which is not equal to itself, is None, as in the document of the command.
    """
    if isinstance(value, dict):
        return {k: _compared(v) for k, v in value.items() if k not in _NOT_COMPARED}
    if isinstance(value, list):
        return [_compared(entry) for entry in value]
    if isinstance(value, np.ndarray):
        return _compared(value.tolist())
    return None if isinstance(value, float) and np.isnan(value) else value


#: Measures by an exponent or a degree, which is a text in the document.
_BY_NUMBER = ("worst_case_error", "riesz_energy", "condition")


def _with_numbers(measures: Any) -> Any:
    """Return measures with numbers as the keys of those that depend on an exponent or a degree."""
    if not isinstance(measures, dict):
        return measures
    return {
        name: {_number(key): value for key, value in measure.items()}
        if name in _BY_NUMBER and isinstance(measure, dict)
        else measure
        for name, measure in measures.items()
    }


def _number(key: str) -> float:
    number = float(key)
    return int(number) if number.is_integer() else number


def _array(entries: list[Any]) -> NDArray[Any]:
    """Return entries as an array: numbers, strings, rows of numbers, or objects."""
    present = [entry for entry in entries if entry is not None]
    if all(isinstance(entry, str) for entry in present) and present:
        if len(present) == len(entries):
            return np.array(entries, dtype=np.str_)
    elif all(isinstance(entry, bool) for entry in present) and present:
        if len(present) == len(entries):
            return np.array(entries, dtype=np.bool_)
    elif all(_is_number(entry) for entry in present):
        is_whole = len(present) == len(entries) and all(isinstance(x, int) for x in present)
        if present and is_whole:
            return np.array(entries, dtype=np.int64)
        return np.array([np.nan if entry is None else entry for entry in entries], np.float64)
    elif all(isinstance(entry, list) for entry in present):
        lengths = {len(entry) for entry in present}
        if len(lengths) == 1 and all(_is_number(x) or x is None for e in present for x in e):
            none = [None] * lengths.pop()
            rows = [none if entry is None else entry for entry in entries]
            return np.array([[np.nan if x is None else x for x in row] for row in rows], np.float64)
    array = np.empty(len(entries), dtype=np.object_)
    array[:] = entries
    return array


def _is_number(entry: Any) -> bool:
    return isinstance(entry, (int, float)) and not isinstance(entry, bool)


def _error_of(key: str) -> str:
    """Return the key of the error of a number."""
    return "error" if key == "value" else f"{key}_error"


def _text(value: Any, error: Any = None) -> str:
    """Return a value as a table shows it: with four digits, or those that its error justifies."""
    if value is None:
        return "-"
    if isinstance(value, float):
        digits = 4
        if isinstance(error, float) and 0 < error < abs(value) < np.inf:
            # To the second digit of the error, and to no more digits than a number has.
            digits = min(max(digits, int(np.floor(np.log10(abs(value))) - np.floor(np.log10(error))) + 2), 17)
        return f"{value:.{digits}g}"
    if isinstance(value, (list, tuple)):
        if len(value) > 4:
            return f"{len(value)} entries"
        return " ".join(_text(entry) for entry in value)
    if isinstance(value, dict):
        return f"{len(value)} entries"
    return str(value)


def _aligned(rows: list[list[str]]) -> list[str]:
    """Return lines with aligned columns, text to the left and numbers to the right."""
    columns = list(zip(*rows))
    widths = [max(map(len, column)) for column in columns]
    left = [not all(_looks_like_number(cell) for cell in column[1:]) for column in columns]
    return [
        "  ".join(
            f"{cell:<{width}}" if to_left else f"{cell:>{width}}"
            for cell, width, to_left in zip(row, widths, left)
        ).rstrip()
        for row in rows
    ]


def _looks_like_number(cell: str) -> bool:
    if cell == "-":
        return True
    try:
        float(cell)
    except ValueError:
        return False
    return True
