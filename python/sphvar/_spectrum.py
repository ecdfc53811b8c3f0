"""Angular power spectra, which merge and can be stored."""

from __future__ import annotations

import json
import operator
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias, TypeVar, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar
from ._ask import checked, warn_of, words
from ._checks import degree, whole
from ._functions import IntegrandLike
from ._given import Path, given_points
from ._inputs import Inputs
from ._progress import Progress, reporting
from ._results import Result
from ._sampler import Sampler
from ._transforms import Method

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Where point sets come from: the text of a sampler, a `Sampler`, points of shape (n, 3) or sets of
#: them of shape (m, n, 3), a tuple of points and weights, or the path of a file of points, or several.
SpectrumSource: TypeAlias = Union[
    str, Sampler, Path, Sequence[Path], ArrayLike, tuple[ArrayLike, ArrayLike]
]

_S = TypeVar("_S", bound="_MergedSpectrum")


def floats(numbers: Sequence[float | None]) -> NDArray[np.float64]:
    """Return numbers of a document as an array, with NaN for those that cannot be given."""
    return np.array([np.nan if x is None else x for x in numbers], dtype=np.float64)


class _MergedSpectrum(Result):
    """A spectrum with the exact sums of its realizations."""

    sampler: str
    domain: str
    n: int
    realizations: int

    def __init__(self, sums: _sphvar.SpectrumSums) -> None:
        super().__init__(json.loads(sums.document))
        self._sums = sums

    @property
    def power(self) -> NDArray[np.float64]:
        """The mean power of each band; white noise has 1, and band 0 has n.

        Examples
        --------
        >>> import sphvar
        >>> float(sphvar.spectrum("jittered", 48, lmax=8, exact=True).power[0])
        48.0
        """
        return floats(self._document["power"])

    @property
    def stderr(self) -> NDArray[np.float64]:
        """The standard error of each power: 0 where it is exact, NaN where there is none.

        Examples
        --------
        >>> import sphvar
        >>> float(sphvar.spectrum("fibonacci", 48, lmax=8).stderr[4])
        0.0
        """
        return floats(self._document["stderr"])

    @property
    def n_effective(self) -> float:
        """The mean of ``(sum w)^2 / sum w^2`` over the sets; `n` without weights.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.spectrum("fibonacci", 48, lmax=8).n_effective
        48.0
        """
        return float(self._document.get("n_effective", self._document["n"]))

    def merge(self: _S, *others: _S) -> _S:
        """Return the spectrum of the realizations of all.

        The sums of realizations are exact: any parts in any order are bit-identical to one run.
        Parts of the realizations of a sampler are those of the keyword `shard` of
        `sphvar.spectrum`; spectra of given points are of other sets of the same number of points.

        Parameters
        ----------
        *others
            Spectra of the same bands, computed in the same way.

        Returns
        -------
        Spectrum or SquareSpectrum
            A new spectrum. Pair correlations are not merged.

        Raises
        ------
        TypeError
            For other objects than spectra of the same domain.
        ValueError
            If the samplers, numbers of points, bands, accuracies, seeds or versions differ, if a
            realization is in several, or for spectra in closed form.

        Examples
        --------
        >>> import sphvar
        >>> parts = [sphvar.spectrum("jittered", 48, realizations=6, shard=(i, 3)) for i in (1, 2, 3)]
        >>> sphvar.Spectrum.merge(*parts) == sphvar.spectrum("jittered", 48, realizations=6)
        True
        """
        sums = self._sums
        for other in others:
            if type(other) is not type(self):
                kinds = f"{type(self).__name__} and {type(other).__name__}"
                raise TypeError(f"expected spectra of the same domain, got {kinds}")
            sums = sums.merged(other._sums)
        return type(self)(sums)

    def __add__(self: _S, other: _S) -> _S:
        if not isinstance(other, _MergedSpectrum):
            return NotImplemented
        return self.merge(other)

    def __radd__(self: _S, other: object) -> _S:
        # The first term of the builtin `sum`.
        return self if isinstance(other, int) and other == 0 else NotImplemented

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), self._sums.to_bytes())


def _restored(kind: type[_S], stored: bytes) -> _S:
    """Return a spectrum that was pickled."""
    return kind(_sphvar.SpectrumSums.from_bytes(stored))


class Spectrum(_MergedSpectrum):
    """The mean angular power spectrum of points on the sphere or hemisphere.

    ``P(l) = 4 pi / n / (2l + 1) sum_m abs(sum_k conj(Y_lm(x_k)))^2``: white noise has P(l) = 1 for
    l >= 1, and P(0) = n. On the hemisphere, where antipodes are the same point, only even degrees
    exist.

    Spectra are added with ``+`` or `merge`, pickled and copied. The document of `to_dict` is that of
    ``sphvar spectrum --json``.

    Attributes
    ----------
    sampler : str
        The sampler with its parameters, or the name of the points.
    domain : str
        ``sphere`` or ``hemisphere``.
    n : int
        The number of points of a set.
    lmax : int
        The largest degree.
    realizations : int
        The number of sets of which this is the mean; 0 for a closed form.
    tail_even, tail_odd : float
        The mean power of even and odd degrees beyond `lmax`.
    pairs : dict
        The pair correlation and Ripley's functions, if they were requested.
    seconds : float
        The time that the spectrum took.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown: ClassVar[tuple[str, ...]] = (
        "sampler",
        "domain",
        "n",
        "n_effective",
        "lmax",
        "realizations",
    )

    lmax: int
    tail_even: float
    tail_odd: float
    pairs: dict[str, Any]
    seconds: float

    @property
    def l(self) -> NDArray[np.int64]:
        """The degrees; on the hemisphere the even ones.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.spectrum("fibonacci", 12, lmax=4, hemisphere=True).l
        array([0, 2, 4])
        """
        return np.array(self._document["l"], dtype=np.int64)

    @property
    def omega(self) -> NDArray[np.float64]:
        """The degrees over the square root of the number of points.

        Examples
        --------
        >>> import sphvar
        >>> float(sphvar.spectrum("fibonacci", 16, lmax=8).omega[-1])
        2.0
        """
        return np.asarray(self.l / np.sqrt(self.n), dtype=np.float64)

    def plot(self, ax: Axes | None = None, *, pairs: bool = False) -> Axes:
        """Plot the power against ``l / sqrt(n)``, or the pair correlation, with standard errors.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            Where to plot; a new figure by default.
        pairs : bool
            Plot the pair correlation against the angle instead, of a spectrum with ``pairs=True``.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ImportError
            Without matplotlib.
        ValueError
            If the pair correlation was not estimated.

        Examples
        --------
        >>> import sphvar
        >>> axes = sphvar.spectrum("jittered", 48, realizations=4).plot()
        """
        from . import _plots

        if pairs:
            if not self._document.get("pairs"):
                raise ValueError("pairs: not estimated; call spectrum with pairs=True")
            return _plots.pairs(ax, self.pairs, self.sampler)
        return _plots.spectrum(ax, self.l, self.power, self.stderr, self.n, self.sampler)


class SquareSpectrum(_MergedSpectrum):
    """The mean power spectrum of points of the unit square under random toroidal shifts.

    The power of a frequency is ``abs(sum_j exp(-2 pi i k.u_j))^2 / n``: white noise has 1, and
    (0, 0) has n. The document of `to_dict` is that of ``sphvar spectrum --square --json``.

    Attributes
    ----------
    sampler : str
        The sampler with its parameters, or the name of the points.
    domain : str
        ``square``.
    n : int
        The number of points of a set.
    kmax : int
        The largest length of a frequency.
    realizations : int
        The number of sets of which this is the mean; 0 for a closed form.
    tail, tail_u, tail_v : float
        The mean power beyond `kmax` off the axes, and on each of them.
    seconds : float
        The time that the spectrum took.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown: ClassVar[tuple[str, ...]] = ("sampler", "n", "n_effective", "kmax", "realizations")

    kmax: int
    tail: float
    tail_u: float
    tail_v: float
    seconds: float

    @property
    def k(self) -> NDArray[np.int64]:
        """The frequencies, of shape (m, 2); of k and -k, which have the same power, one is given.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.spectrum("jittered-square", 64, square=True, kmax=4, exact=True).k[0]
        array([0, 0])
        """
        pairs = [self._document["k1"], self._document["k2"]]
        return np.array(pairs, dtype=np.int64).T

    @property
    def radius(self) -> NDArray[np.int64]:
        """The radii r of rings of frequencies, ``r - 1/2 <= abs(k) < r + 1/2``, from 1.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.spectrum("jittered-square", 64, square=True, kmax=4, exact=True).radius
        array([1, 2, 3])
        """
        return np.array(self._document["radius"], dtype=np.int64)

    @property
    def radial_power(self) -> NDArray[np.float64]:
        """The mean power of each ring.

        Examples
        --------
        >>> import sphvar
        >>> len(sphvar.spectrum("halton", 64, square=True, kmax=4, realizations=2).radial_power)
        3
        """
        return floats(self._document["radial_power"])

    @property
    def radial_stderr(self) -> NDArray[np.float64]:
        """The standard error of the mean power of each ring; 0 where it is exact.

        Examples
        --------
        >>> import sphvar
        >>> square = sphvar.spectrum("jittered-square", 64, square=True, kmax=4, exact=True)
        >>> float(square.radial_stderr[0])
        0.0
        """
        return floats(self._document["radial_stderr"])

    @property
    def anisotropy(self) -> NDArray[np.float64]:
        """The relative variance of the power over each ring; NaN where there is no power.

        Examples
        --------
        >>> import sphvar
        >>> len(sphvar.spectrum("halton", 64, square=True, kmax=4, realizations=2).anisotropy)
        3
        """
        return floats(self._document["anisotropy"])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the mean power of rings against ``abs(k) / sqrt(n)``, with its standard error.

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
        >>> axes = sphvar.spectrum("halton", 64, square=True, realizations=4).plot()
        """
        from . import _plots

        axes = _plots.spectrum(
            ax, self.radius, self.radial_power, self.radial_stderr, self.n, self.sampler
        )
        axes.set_xlabel(r"$|k| / \sqrt{N}$")
        axes.set_ylabel("mean power")
        return axes


@overload
def spectrum(
    source: SpectrumSource,
    n: int | None = None,
    *,
    square: Literal[False] = False,
    lmax: int | None = None,
    weights: ArrayLike | None = None,
    realizations: int | None = None,
    shard: tuple[int, int] | None = None,
    seed: int | None = None,
    hemisphere: bool = False,
    nearest: bool = False,
    exact: bool = False,
    method: Method = "auto",
    epsilon: float = 1e-12,
    pairs: bool = False,
    max_angle: float | None = None,
    bins: int | None = None,
    density: IntegrandLike | None = None,
    columns: str | None = None,
    hdu: int | str | None = None,
    join: bool = False,
    skip_invalid: bool = False,
    normalize: bool = False,
    progress: Progress = None,
) -> Spectrum: ...


@overload
def spectrum(
    source: SpectrumSource,
    n: int | None = None,
    *,
    square: Literal[True],
    kmax: int | None = None,
    weights: ArrayLike | None = None,
    realizations: int | None = None,
    shard: tuple[int, int] | None = None,
    seed: int | None = None,
    nearest: bool = False,
    exact: bool = False,
    epsilon: float = 1e-12,
    columns: str | None = None,
    hdu: int | str | None = None,
    join: bool = False,
    skip_invalid: bool = False,
    normalize: bool = False,
    progress: Progress = None,
) -> SquareSpectrum: ...


@checked
def spectrum(
    source: SpectrumSource,
    n: int | None = None,
    *,
    square: bool = False,
    lmax: int | None = None,
    kmax: int | None = None,
    weights: ArrayLike | None = None,
    realizations: int | None = None,
    shard: tuple[int, int] | None = None,
    seed: int | None = None,
    hemisphere: bool = False,
    nearest: bool = False,
    exact: bool = False,
    method: Method = "auto",
    epsilon: float = 1e-12,
    pairs: bool = False,
    max_angle: float | None = None,
    bins: int | None = None,
    density: IntegrandLike | None = None,
    columns: str | None = None,
    hdu: int | str | None = None,
    join: bool = False,
    skip_invalid: bool = False,
    normalize: bool = False,
    progress: Progress = None,
) -> Spectrum | SquareSpectrum:
    """Return the mean angular power spectrum of a sampler or of points.

    The result is bit-identical to that of ``sphvar spectrum`` with the same options.

    Parameters
    ----------
    source : str, Sampler, array_like, tuple or path
        A sampler such as ``"jittered"`` or ``"poisson-disk:radius=0.5"``, or a `Sampler`; points of
        shape (n, 3), m sets of shape (m, n, 3), each a realization, or a tuple of points and
        weights; a `pathlib.Path` of a file of points, or several.
    n : int, optional
        The number of points of a sampler.
    square : bool
        Use the unit square: points of shape (n, 2), patterns of the square and random toroidal
        shifts.
    lmax, kmax : int, optional
        The largest degree or, on the square, the largest length of a frequency; ``4 sqrt(n)``, at
        least 32, by default.
    weights : array_like, optional
        Weights of points, of shape (n,) or (m, n).
    realizations : int, optional
        The number of realizations of a sampler, 100 by default.
    shard : (int, int), optional
        (i, k) computes part i of k equal parts of the realizations, counted from 1, for
        `Spectrum.merge`.
    seed : int, optional
        The seed of all random numbers; that of a `Sampler`, otherwise 0, by default.
    hemisphere : bool
        Use the hemisphere z >= 0, where only even degrees exist; points below are replaced by their
        antipodes.
    nearest : bool
        Use the valid number of points nearest to `n`.
    exact : bool
        Evaluate the mean spectrum in closed form: no realizations, no error.
    method : {'auto', 'exact', 'fast'}
        The transform: by the definition, fast, or the one with less work.
    epsilon : float
        The accuracy of the fast transform, from 1e-13 to 0.1.
    pairs : bool
        Estimate the pair correlation and Ripley's functions too, in the attribute ``pairs``.
    max_angle : float, optional
        With `pairs`: the largest angle between two points in degrees.
    bins : int, optional
        With `pairs`: the number of bins of the angle, 100 by default.
    density : integrand, optional
        With `pairs`: the local density by which angles are scaled, or ``"weights"`` for the inverse
        of the weights.
    columns, hdu, join, skip_invalid, normalize
        How files are read, as the options of ``sphvar spectrum --points``: the roles of columns as in
        ``"ra=RAJ2000,dec=DEJ2000,w=WEIGHT"``, the HDU of FITS files, whether files are joined to one
        set, whether invalid rows are skipped, and whether vectors of any length are scaled.
    progress : bool or callable, optional
        True for a bar of tqdm, or a callable of the work done and expected.

    Returns
    -------
    Spectrum or SquareSpectrum
        The mean power of every degree or frequency, with its standard error. It is NaN for a single
        given set, and 0 for deterministic patterns.

    Raises
    ------
    ValueError
        For a value that is not valid, in the words of the command.
    TypeError
        For an unknown keyword, or an array that is not of real numbers.
    OSError
        For files that cannot be read.
    MemoryError
        Before the memory is taken.

    Examples
    --------
    >>> import sphvar
    >>> spectrum = sphvar.spectrum("jittered", 192, realizations=50)
    >>> spectrum.lmax, spectrum.realizations
    (52, 50)
    >>> bool(spectrum.power[1] < 0.1 < spectrum.power[-1])
    True

    Points of your own:

    >>> points = sphvar.Sampler("fibonacci", 100).random(1)[0]
    >>> bool((sphvar.spectrum(points, lmax=8).power[1:] < 0.01).all())
    True
    """
    options: dict[str, Any] = dict(
        n=n,
        lmax=None if lmax is None else degree("lmax", lmax),
        kmax=kmax,
        realizations=None if realizations is None else whole("realizations", realizations, 1),
        hemisphere=hemisphere,
        square=square,
        nearest=nearest,
        exact=exact,
        method=None if method == "auto" else method,
        epsilon=None if epsilon == 1e-12 else epsilon,
        pairs=pairs,
        max_angle=max_angle,
        bins=bins,
        columns=columns,
        hdu=hdu,
        join=join,
        skip_invalid=skip_invalid,
        normalize=normalize,
    )
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        points: Any = source
        if isinstance(source, Sampler):
            # The call may have others.
            options["hemisphere"] = hemisphere or source.hemisphere
            options["square"] = square = square or source.square
            seed = source.seed if seed is None else seed
            if n is None and isinstance(source.spec, str):
                options["n"] = source.n
            points = source.spec
        inputs = Inputs(session, [points, density], square)
        if not isinstance(points, str):
            files = given_points(points, inputs, weights=weights, square=square)
            question = words("spectrum", [], options) + [f"--points={file}" for file in files]
        elif weights is None:
            question = words("spectrum", [points], options)
        else:
            raise ValueError(f"weights: they are for points, not for the sampler {points}")
        if density is not None:
            question += words("", [], {"density": inputs.integrand(density)})[1:]
        question += words("", [], {"seed": 0 if seed is None else seed})[1:]
        part = None if shard is None else _part(shard)
        sums = _sphvar.spectrum(session, question, part)
        warn_of(session)
    return SquareSpectrum(sums) if square else Spectrum(sums)


def _part(shard: tuple[int, int]) -> tuple[int, int]:
    """Return which of how many parts of the realizations is computed."""
    try:
        part, parts = map(operator.index, shard)
    except (TypeError, ValueError):
        raise TypeError(f"shard: expected two integers (i, k), got {shard!r}") from None
    if not 1 <= part <= parts:
        raise ValueError(f"shard: expected (i, k) with 1 <= i <= k, got {shard!r}")
    return part, parts
