"""Samplers that draw sets of points as arrays, and sets of rotations."""

from __future__ import annotations

import sys
from typing import Any, Final, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar
from ._ask import checked, in_keywords, warn
from ._checks import STREAMS, seed_of, unmasked, whole
from ._functions import is_equal
from ._progress import Progress, reporting

#: Sets of points of shape (m, n, 3), or a list of sets where their numbers of points differ.
PointSets: TypeAlias = Any


class Sampler:
    """A sampler of directions or of points of the unit square, which draws numbered sets.

    Set *i* is a function of the sampler, its options, the seed and *i* alone: it depends neither on
    the calls that drew the sets before it nor on threads, and has the bytes that the command
    ``sphvar sample`` writes. A sampler counts the sets that it has drawn, and continues.

    Parameters
    ----------
    spec : str or array_like or tuple
        The sampler: a text such as ``"fibonacci"`` or ``"step:alpha=1"`` (`list_samplers` has the
        names), unit vectors of shape (n, 3), or sets of them of shape (m, n, 3); ``normalize=True``
        takes vectors of any length. A tuple is one of points and weights of shape (n,) or (m, n).
    n : int, optional
        The number of points of a set. Points that are given have a number of their own, as have
        ``"file:PATH"`` and ``"design:t=T"``; another `n` for given points is an error.
    seed : int, optional
        The seed of all random numbers, from 0 to 2**64 - 1.
    hemisphere : bool, optional
        Sample the hemisphere z >= 0 instead of the sphere.
    square : bool, optional
        Sample the unit square instead of the sphere; points are then u, v in [0, 1).
    rotate : bool, optional
        Apply an independent uniform random rotation to every set.
    shift : bool, optional
        On the square, apply an independent uniform shift modulo 1 to every set.
    nearest : bool, optional
        Use the valid number of points nearest to `n`.
    **params
        Parameters of the sampler, which are added to its text: ``Sampler("step", 64, alpha=1)`` is
        ``Sampler("step:alpha=1", 64)``. A ``_`` in the name of a parameter stands for ``-``.

    Raises
    ------
    TypeError
        If an argument has another type; `n` and `seed` are integers, not truth values or floats.
    ValueError
        If the sampler, a parameter or the number of points is invalid, or elements of an array are
        masked.
    OSError
        If a file cannot be read.
    MemoryError
        If the points do not fit in memory.

    Notes
    -----
    Samplers are equal (``==``) if they have the same arguments and `position`.

    Two samplers with the same seed draw from independent random streams, unless they are equal or
    sequences: the first points of a set of ``"sobol:warp=cosine"`` are a set of fewer points.

    Examples
    --------
    >>> import sphvar
    >>> sampler = sphvar.Sampler("jittered", 48, seed=7)
    >>> sampler.random(2).shape
    (2, 48, 3)
    >>> sampler.reset().random(3)[1:].tolist() == sampler.reset().fast_forward(1).random(2).tolist()
    True

    Weights, for patterns that have them:

    >>> lobes = sphvar.Sampler("sobol", 256, hemisphere=True, warp="cosine")
    >>> points = lobes.random()
    >>> integral = (lobes.weights * points[:, :, 2]).sum()
    >>> bool(abs(integral - 3.14159265358979) < 1e-12)
    True
    """

    __slots__ = (
        "_given",
        "_native",
        "_options",
        "_position",
        "_requested",
        "_seed",
        "_spec",
        "_weights",
    )

    @in_keywords
    def __init__(
        self,
        spec: str | ArrayLike | tuple[ArrayLike, ArrayLike],
        n: SupportsIndex | None = None,
        *,
        seed: SupportsIndex = 0,
        hemisphere: bool = False,
        square: bool = False,
        rotate: bool = False,
        shift: bool = False,
        nearest: bool = False,
        **params: Any,
    ) -> None:
        if square and hemisphere:
            raise ValueError("hemisphere does not apply to square; the square is a domain of its own")
        if square and rotate:
            raise ValueError("rotate does not apply to square; use shift")
        if shift and not square:
            raise ValueError("shift requires square; use rotate for directions")
        self._requested = _count(n)
        self._seed = seed_of(seed)
        self._options = {
            "hemisphere": bool(hemisphere),
            "square": bool(square),
            "rotate": bool(rotate),
            "shift": bool(shift),
            "nearest": bool(nearest),
        }
        self._given: tuple[NDArray[Any], NDArray[Any] | None] | None = None
        self._spec = with_parameters(spec if isinstance(spec, str) else "file:points", params)
        if not isinstance(spec, str):
            points, weights = spec if isinstance(spec, tuple) and len(spec) == 2 else (spec, None)
            # A copy, so that later changes of the array change neither sets nor what is pickled.
            self._given = (
                _frozen("points", points),
                None if weights is None else _frozen("weights", weights),
            )
        self._build()
        if self._given is not None and self._requested not in (None, self.n):
            raise ValueError(f"n = {self._requested}, but there are {self.n} points in each given set")
        self._position = 0
        self._weights: Any = None

    def _build(self) -> None:
        options = self._options
        points, weights = self._given if self._given is not None else (None, None)
        self._native = _sphvar.NumberedSets(
            "square" if options["square"] else "directions",
            self._spec,
            self._requested,
            self._seed,
            options["hemisphere"],
            options["rotate"] or options["shift"],
            options["nearest"],
            points,
            weights,
        )
        for remark in self._native.remarks:
            if remark.startswith("warning: "):
                warn(remark.removeprefix("warning: "))

    @property
    def spec(self) -> Any:
        """The sampler with its parameters as a text; given points as they were given.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.Sampler("step", 64, alpha=1).spec
        'step:alpha=1'
        """
        if self._given is None:
            return self._spec
        points, weights = self._given
        return points if weights is None else (points, weights)

    @property
    def _point_parameters(self) -> str:
        """The parameters of given points, as they follow the name of the points in a text."""
        return "" if self._given is None else self._spec.removeprefix("file:points")

    @property
    def n(self) -> int:
        """The number of points of every set; where it varies, the requested or the mean number.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.Sampler("healpix", 100, nearest=True).n
        108
        """
        return self._native.n_points

    @property
    def seed(self) -> int:
        """The seed of all random numbers."""
        return self._seed

    @property
    def hemisphere(self) -> bool:
        """Whether the points are those of the hemisphere z >= 0."""
        return self._options["hemisphere"]

    @property
    def square(self) -> bool:
        """Whether the points are those of the unit square."""
        return self._options["square"]

    @property
    def rotate(self) -> bool:
        """Whether every set has an independent uniform random rotation."""
        return self._options["rotate"]

    @property
    def position(self) -> int:
        """The number of the set that is drawn next, from 0."""
        return self._position

    @property
    def weights(self) -> Any:
        """The weights of the points of the last call of `random`, of shape (m, n).

        ``None`` if the points have equal weights or none were drawn. Weights of samplers with ``warp=``
        are 1/(n p) for a density p, so that the sum of w f over the points estimates an integral; of
        others, only ratios matter.

        Examples
        --------
        >>> import sphvar
        >>> rule = sphvar.Sampler("gauss-legendre", 72)
        >>> rule.random().shape, rule.weights.shape
        ((1, 72, 3), (1, 72))
        """
        return self._weights

    def random(self, m: SupportsIndex | None = None, *, progress: Progress = None) -> PointSets:
        """Draw the next sets.

        Parameters
        ----------
        m : int, optional
            The number of sets. The default is 1, and each set once for points that are given or
            read from a file; with `m`, each set is one of the given ones, drawn uniformly.
        progress : bool or callable, optional
            ``True`` shows a bar if tqdm is installed; a callable is given the work done and expected,
            some 20 times a second.

        Returns
        -------
        ndarray
            Unit vectors of shape (m, n, 3), or points u, v of shape (m, n, 2), in C order. If the
            numbers of points of the sets differ, as those of ``"poisson-disk:mode=saturated"``, a
            list of m arrays.

        Raises
        ------
        MemoryError
            If the sets do not fit in memory; none is taken.
        RuntimeError
            If a set cannot be generated.

        Notes
        -----
        Sets are generated in several threads without the lock of the interpreter if they take longer
        than a millisecond; Ctrl-C stops them. The cost is that of the sampler (`list_samplers`).

        Examples
        --------
        >>> import sphvar
        >>> sampler = sphvar.Sampler("white-noise", 1000)
        >>> sampler.random(5).shape, sampler.position
        ((5, 1000, 3), 5)
        """
        native = self._native
        in_order = m is None and native.n_given is not None
        count = (native.n_given or 1) if m is None else whole("m", m, 1)
        if count * native.n_points > sys.maxsize // 64:
            raise MemoryError(f"{count} sets of {native.n_points} points do not fit in memory")
        if self._position + count > STREAMS:
            raise ValueError(f"sets are numbered up to {STREAMS - 1}")
        if progress is None:
            points, weights = native.draw(self._position, count, in_order, None)
        else:
            with reporting(progress) as report:
                points, weights = native.draw(self._position, count, in_order, report)
        self._weights = weights
        self._position += count
        return points

    def reset(self) -> Sampler:
        """Continue with set 0.

        Returns
        -------
        Sampler
            This sampler.

        Examples
        --------
        >>> import sphvar
        >>> sampler = sphvar.Sampler("white-noise", 10)
        >>> first = sampler.random()
        >>> bool((sampler.reset().random() == first).all())
        True
        """
        self._position = 0
        self._weights = None
        return self

    def fast_forward(self, k: SupportsIndex) -> Sampler:
        """Skip sets, which costs nothing.

        Parameters
        ----------
        k : int
            The number of sets, at least 0.

        Returns
        -------
        Sampler
            This sampler.

        Examples
        --------
        >>> import sphvar
        >>> sphvar.Sampler("white-noise", 10).fast_forward(10**9).position
        1000000000
        """
        k = whole("k", k)
        if self._position + k > STREAMS:
            raise ValueError(f"sets are numbered up to {STREAMS - 1}")
        self._position += k
        self._weights = None
        return self

    def __repr__(self) -> str:
        if self._given is None:
            parts = [repr(self._spec), str(self.n)]
        else:
            weighted = "" if self._given[1] is None else "weighted "
            parts = [f"<{weighted}points of shape {self._given[0].shape}>"]
        parts += [f"seed={self.seed}"] if self.seed else []
        parts += [f"{key}=True" for key in _FLAGS if self._options[key]]
        return f"Sampler({', '.join(parts)})"

    def __eq__(self, other: object) -> bool:
        # Equal samplers draw the same sets, and the same ones next.
        if type(other) is not type(self):
            return NotImplemented
        compared = ("_spec", "_given", "_requested", "_seed", "_options", "_position")
        return all(is_equal(getattr(self, name), getattr(other, name)) for name in compared)

    # Samplers change as they draw.
    __hash__ = None  # type: ignore[assignment]

    def __copy__(self) -> Sampler:
        # Everything that is shared never changes.
        twin = object.__new__(type(self))
        for slot in Sampler.__slots__:
            if hasattr(self, slot):
                setattr(twin, slot, getattr(self, slot))
        return twin

    def __deepcopy__(self, memo: dict[int, Any]) -> Sampler:
        return self.__copy__()

    def __getstate__(self) -> dict[str, Any]:
        # The native sets are made anew.
        slots = [slot for slot in Sampler.__slots__ if slot != "_native"]
        return {slot: getattr(self, slot) for slot in slots}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for slot, value in state.items():
            setattr(self, slot, value)
        self._build()


_FLAGS: Final = ("hemisphere", "square", "rotate", "shift", "nearest")


@checked
def rotations(
    spec: str,
    n: SupportsIndex,
    realizations: SupportsIndex | None = None,
    *,
    seed: SupportsIndex = 0,
    rotate: bool = False,
    nearest: bool = False,
    format: str = "quaternions",
    return_weights: bool = False,
    progress: Progress = None,
) -> Any:
    """Draw sets of rotations, as the command ``sphvar rotations`` does.

    Rotations are active: the matrix R takes a vector v of the body to R v in the laboratory.

    Parameters
    ----------
    spec : str
        The pattern, such as ``"super-fibonacci"``; ``list_samplers("rotations")`` has all.
    n : int
        The number of rotations of a set.
    realizations : int, optional
        The number of sets. Without it, the result is one set without an axis for sets.
    seed : int, optional
        The seed of all random numbers, from 0 to 2**64 - 1.
    rotate : bool, optional
        Multiply every set by an independent uniform random rotation, which makes means unbiased.
    nearest : bool, optional
        Use the valid number of rotations nearest to `n`.
    format : {"quaternions", "matrices", "euler", "euler-degrees"}, optional
        Unit quaternions w, x, y, z with w >= 0 (the order of the command; scipy has w last unless
        ``scalar_first=True``), matrices, or angles alpha, beta, gamma of R = Rz(alpha) Ry(beta) Rz(gamma).
    return_weights : bool, optional
        Also return the weights of the rotations, ``None`` if they are equal; only ratios matter.
    progress : bool or callable, optional
        As for `Sampler.random`.

    Returns
    -------
    ndarray
        Rotations of shape (n, 4), (n, 3, 3) or (n, 3), with an axis of sets before it if
        `realizations` is given.
    weights : ndarray or None
        Of shape (n,) or (realizations, n), with `return_weights`.

    Raises
    ------
    ValueError
        If the pattern, the number of rotations or the format is invalid.
    MemoryError
        If the rotations do not fit in memory.

    Examples
    --------
    >>> import sphvar
    >>> sphvar.rotations("super-fibonacci", 100).shape
    (100, 4)
    >>> sphvar.rotations("uniform", 10, 3, format="matrices").shape
    (3, 10, 3, 3)
    """
    if format not in ("quaternions", "matrices", "euler", "euler-degrees"):
        raise ValueError(
            f"format must be quaternions, matrices, euler or euler-degrees, got {format!r}"
        )
    count = 1 if realizations is None else whole("realizations", realizations, 1)
    native = _sphvar.NumberedSets(
        format, spec, _count(n), seed_of(seed), False, bool(rotate), bool(nearest), None, None
    )
    if count * native.n_points > sys.maxsize // 128:
        raise MemoryError(f"{count} sets of {native.n_points} rotations do not fit in memory")
    with reporting(progress) as report:
        sets, weights = native.draw(0, count, False, report)
    if realizations is None:
        sets, weights = sets[0], None if weights is None else weights[0]
    return (sets, weights) if return_weights else sets


def with_parameters(spec: str, params: dict[str, Any]) -> str:
    """Return the text of a sampler or integrand with further parameters.

    Parameters
    ----------
    spec
        A text such as ``"step"`` or ``"step:alpha=1"``.
    params
        Numbers, texts and truth values by name; ``None`` omits one.

    Returns
    -------
    str
        The text as the command reads it.
    """
    text, separator = spec, "," if ":" in spec else ":"
    for name, value in params.items():
        if value is not None:
            text += f"{separator}{name.replace('_', '-')}={_parameter(name, value)}"
            separator = ","
    return text


def _parameter(name: str, value: Any) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return _sphvar.quote(value)
    raise TypeError(f"{name}: expected a number, a text or a truth value, got {type(value).__name__}")


def _count(n: SupportsIndex | None) -> int | None:
    number = None if n is None else whole("n", n, 1)
    if number is not None and number > sys.maxsize:
        raise MemoryError(f"a set of {number} points does not fit in memory")
    return number


def _frozen(name: str, given: ArrayLike) -> NDArray[Any]:
    """Return a copy that cannot be changed."""
    array = unmasked(name, given)
    if array.dtype.kind not in "fiu" and array.size:
        raise TypeError(
            f"{name}: expected real numbers, got {type(given).__name__} of dtype {array.dtype}; a sampler "
            "is a text, an array of points or a tuple of points and weights"
        )
    if array.ndim == 0 and not isinstance(given, (np.generic, np.ndarray)):
        raise TypeError(
            f"a sampler is a text, an array of points or a tuple of points and weights, got {given!r}"
        )
    _sphvar.check_memory(name, array.size)
    copy = np.array(array, order="C")
    copy.flags.writeable = False
    return copy
