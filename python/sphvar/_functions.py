"""Integrands as Python has them: callables, arrays, images, and expressions of several."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, Union, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._checks import degree as checked_degree
from ._checks import unmasked, whole

if TYPE_CHECKING:
    from . import _sphvar

#: A function of unit vectors of shape (n, 3) that returns their values, of shape (n,).
VectorizedCallable: TypeAlias = Callable[[NDArray[np.float64]], ArrayLike]

#: Returns a name that occurs in no text of the call: the wanted one, if it is free.
_Namer: TypeAlias = Callable[[str], str]

_QUANTITIES = {"energy": "", "cl": ",quantity=cl"}


@runtime_checkable
class Given(Protocol):
    """An integrand that a session reads under a name."""

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        """Add the integrand to a session and return its text.

        Without ``energies`` those of functions are not found, so that only the values that a question
        needs are taken.
        """


class _Wrapper:
    """What integrands that hold arrays have in common: they compare by what they hold."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return is_equal(vars(self), vars(other))

    # Arrays can change.
    __hash__ = None  # type: ignore[assignment]

    def _not_supported(self, other: object) -> Any:
        raise TypeError(
            f"{type(self).__name__} has no arithmetic; Expression combines integrands: "
            "Expression('f * cosine', f=...)"
        )

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __matmul__ = _not_supported
    # Arrays leave operators to this class, and do not apply it to every number.
    __array_ufunc__ = None


def is_equal(one: Any, other: Any) -> bool:
    """Return whether two values are equal; arrays if they have the same shape and numbers, NaN too."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(is_equal(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)) and type(one) is type(other):
        return len(one) == len(other) and all(map(is_equal, one, other))
    return bool(one == other)


class Function(_Wrapper):
    """A callable as an integrand, with options such as its degree.

    A callable on its own is an integrand too: its degree and energies are found from its values.

    Parameters
    ----------
    function
        A vectorized callable: it takes unit vectors as a read-only array of shape (n, 3), with n at
        most 65536, and returns n finite real numbers, as ``lambda points: points[:, 2]`` does.
    degree
        The degree of the polynomial in x, y and z that the function equals, to the accuracy that
        you need, everywhere or between the ``edges``. Energies and the integral then need about
        ``2 (degree + lmax)**2`` values and are exact to rounding. Without a degree they are found by
        doubling a degree until they are known to a tolerance; the error that remains is part of
        every prediction.
    edges
        Circles across which values or derivatives jump, as pairs of an axis of length 3 and an
        angle from it in degrees: ``[((0, 0, 1), 90)]`` is the equator. Only with ``degree``.
    tolerance
        The error of energies at which the doubling stops, summed over all degrees and relative to
        their total without the mean: above 0, at most 0.1. Only without ``degree``.
    min_evaluations
        The number of values to take at least, 16384 unless given; features that cover less than
        about ``12 pi`` divided by it may be missed. Only without ``degree``.
    max_evaluations
        The number of values not to exceed, at least 14290; 4194304 unless given. Only without
        ``degree``. Sums and products with a function that the values do not resolve take as many as
        4194304 of their own.
    hemisphere
        Whether the function has values above the equator only. Only without ``degree``.
    name
        Its name in messages and results, that of the callable unless given.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> ridge = sphvar.Function(lambda p: np.abs(p[:, 0]), degree=1, edges=[((1, 0, 0), 90)])
    >>> round(sphvar.integrate(ridge).exact / np.pi, 12)
    2.0
    """

    def __init__(
        self,
        function: VectorizedCallable,
        *,
        degree: int | None = None,
        edges: Iterable[tuple[ArrayLike, float]] | None = None,
        tolerance: float | None = None,
        min_evaluations: int | None = None,
        max_evaluations: int | None = None,
        hemisphere: bool = False,
        name: str | None = None,
    ) -> None:
        if not callable(function):
            raise TypeError(f"expected a callable, got {type(function).__name__}")
        #: The callable.
        self.function = function
        #: Its name in messages.
        self.name = _name_of(function) if name is None else name
        counts = {"min_evaluations": min_evaluations, "max_evaluations": max_evaluations}
        found = {
            "tolerance": tolerance,
            **{key: None if n is None else whole(key, n, 1, 2**53) for key, n in counts.items()},
            "hemisphere": hemisphere or None,
        }
        if degree is None and edges is not None:
            raise ValueError("edges: the degree between them is missing: degree=")
        if degree is not None:
            given = [keyword for keyword, value in found.items() if value is not None]
            if given:
                raise ValueError(f"{given[0]}: the degree is given, so nothing is found")
        #: The degree, or None where it is found.
        self.degree = None if degree is None else checked_degree("degree", degree)
        self._edges = None if edges is None else [_edge(axis, angle) for axis, angle in edges]
        self._found: dict[str, Any] = {k: value for k, value in found.items() if value is not None}

    def __call__(self, points: NDArray[np.float64]) -> ArrayLike:
        """Return the values of the callable."""
        return self.function(points)

    def __repr__(self) -> str:
        degree = "" if self.degree is None else f", degree={self.degree}"
        return f"Function({self.name}{degree})"

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        free = name(_word(self.name))
        if not energies and self.degree is None:
            components = session.add_values_function(free, self.function, self.name)
            if components is not None:
                raise ValueError(
                    f"{self.name} returned {components} values for a direction, expected one: shape (n,)"
                )
            return f"function:{free}"
        session.add_function(
            free, self.function, self.name, degree=self.degree, edges=self._edges, **self._found
        )
        return f"function:{free}"


class HealpixMap(_Wrapper):
    """A HEALPix map as an integrand, constant in each pixel.

    Parameters
    ----------
    values
        One real number per pixel: ``12 * nside**2``.
    nest
        Whether they are in nested order, for which nside is a power of two; otherwise in ring order.
    missing
        What pixels without a value (NaN, infinite, masked or healpy's UNSEEN) are: ``"error"``, ``"0"`` or
        the ``"mean"`` of the others.
    name
        Its name in results.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> sphvar.evaluate(sphvar.HealpixMap(np.arange(12.0)), [[0, 0, 1], [0, 0, -1]])
    array([0., 8.])
    """

    def __init__(
        self,
        values: ArrayLike,
        nest: bool = False,
        *,
        missing: str = "error",
        name: str = "map",
    ) -> None:
        if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
            # A pixel without a value, as UNSEEN is.
            filled = np.array(_real("values", values.data))
            filled[np.ma.getmaskarray(values)] = np.nan
            values = filled
        self.values = _real("values", values)
        if self.values.ndim != 1 or not _is_map(self.values.size):
            raise ValueError(f"values: expected shape (12 nside**2,), got {self.values.shape}")
        self.nest = bool(nest)
        self.missing = missing
        self.name = name

    def __repr__(self) -> str:
        return f"HealpixMap({self.values.size} pixels, nest={self.nest})"

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        free = name(_word(self.name))
        session.add_map(free, self.values, self.nest)
        return f"map:{free}" + ("" if self.missing == "error" else f",missing={self.missing}")


class Environment(_Wrapper):
    """An image of all directions as an integrand, such as an HDR light probe.

    Rows run from the top. The options are those of the command's ``env``: see
    ``sphvar list integrands env``.

    Parameters
    ----------
    image
        Linear values of shape (h, w), or (h, w, 3) for red, green and blue. Integers are rejected:
        pictures of 8 bits are not proportional to light.
    channel
        The channel of a colour image: ``"r"``, ``"g"``, ``"b"``, or the luminance unless given.
    projection
        ``"latlong"`` (w = 2 h) or ``"octahedral"`` (w = h).
    up
        The axis that is up in the image: ``"z"``, ``"y"``, ``"x"``, ``"-z"``, ``"-y"`` or ``"-x"``.
    mirror
        Whether columns run eastwards, as in a map of the Earth.
    rotate
        A rotation about the pole in degrees.
    name
        Its name in results.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> sky = sphvar.Environment(np.full((16, 32), 0.5))
    >>> sphvar.evaluate(sky, [[0, 0, 1.0]])
    array([0.5])
    """

    def __init__(
        self,
        image: ArrayLike,
        *,
        channel: str | None = None,
        projection: str = "latlong",
        up: str = "z",
        mirror: bool = False,
        rotate: float = 0.0,
        name: str = "image",
    ) -> None:
        self.image = unmasked("image", image)
        if self.image.dtype.kind in "iub":
            raise TypeError(
                f"image: expected linear values as floats, got dtype {self.image.dtype}: the values of "
                "an 8-bit picture are not proportional to light; decode sRGB first"
            )
        self.image = _real("image", self.image)
        if self.image.ndim not in (2, 3) or self.image.shape[2:] not in ((), (3,)):
            raise ValueError(f"image: expected shape (h, w) or (h, w, 3), got {self.image.shape}")
        self.name = name
        options = {
            "channel": channel,
            "projection": None if projection == "latlong" else projection,
            "up": None if up == "z" else up,
            "mirror": "yes" if mirror else None,
            "rotate": None if rotate == 0 else repr(float(rotate)),
        }
        self._options = "".join(f",{key}={value}" for key, value in options.items() if value)

    def __repr__(self) -> str:
        return f"Environment{self.image.shape}"

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        free = name(_word(self.name))
        session.add_picture(free, self.image)
        return f"env:{free}{self._options}"


class Coefficients(_Wrapper):
    """Spherical-harmonic coefficients of a real function as an integrand.

    Parameters
    ----------
    alm
        Complex numbers in the order of healpy, for ``mmax = lmax``.
    name
        Its name in results.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> constant = sphvar.Coefficients([np.sqrt(4 * np.pi)])
    >>> sphvar.evaluate(constant, [[1.0, 0, 0]])
    array([1.])
    """

    def __init__(self, alm: ArrayLike, *, name: str = "alm") -> None:
        self.alm = unmasked("alm", alm)
        if self.alm.dtype.kind not in "fiuc":
            raise TypeError(f"alm: expected complex numbers, got dtype {self.alm.dtype}")
        if self.alm.ndim != 1 or not _is_triangular(self.alm.size):
            shape = self.alm.shape
            raise ValueError(f"alm: expected shape ((lmax + 1) (lmax + 2) / 2,), got {shape}")
        self.name = name

    def __repr__(self) -> str:
        return f"Coefficients({self.alm.size})"

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        free = name(_word(self.name))
        session.add_coefficients(free, self.alm)
        return f"alm:{free}"


class Energies(_Wrapper):
    """A random function with given energies per degree as an integrand.

    Parameters
    ----------
    values
        One number per degree from 0, none negative.
    quantity
        Their meaning: ``"cl"`` for the angular power ``C_l``, as healpy has it, or ``"energy"`` for
        ``E(l) = (2 l + 1) C_l``.
    errors
        Their standard errors, 0 unless given.
    field
        The number of the random function.
    name
        Its name in results.

    Examples
    --------
    >>> import sphvar
    >>> sphvar.energies(sphvar.Energies([0.0, 2.0, 1.0]), 2)
    array([0., 6., 5.])
    """

    def __init__(
        self,
        values: ArrayLike,
        *,
        quantity: str = "cl",
        errors: ArrayLike | None = None,
        field: int = 0,
        name: str = "energies",
    ) -> None:
        if quantity not in _QUANTITIES:
            raise ValueError(f"quantity: expected 'cl' or 'energy', got {quantity!r}")
        self.values = _real("values", values)
        if self.values.ndim != 1 or not self.values.size:
            raise ValueError(f"values: expected shape (lmax + 1,), got {self.values.shape}")
        self.errors = None if errors is None else _real("errors", errors)
        self.quantity = quantity
        self.field = whole("field", field)
        self.name = name

    def __repr__(self) -> str:
        return f"Energies(lmax={self.values.size - 1}, quantity={self.quantity!r})"

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        free = name(_word(self.name))
        session.add_energies(free, self.values, self.errors)
        field = f",field={self.field}" if self.field else ""
        return f"energy:{free}{_QUANTITIES[self.quantity]}{field}"


class Expression(_Wrapper):
    """An expression of the command with integrands of your own.

    Parameters
    ----------
    text
        Sums and products of named integrands with rotations, as of the option ``--integrand``, in
        which the keywords below are names.
    **functions
        Integrands by their names: callables, arrays, or what :func:`evaluate` takes.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> light = sphvar.Expression("2 * f @ 30/0 - cosine", f=lambda p: p[:, 2] ** 2)
    >>> round(float(sphvar.integrate(light, rtol=1e-6)) / np.pi, 4)
    1.6667
    """

    def __init__(self, text: str, **functions: IntegrandLike) -> None:
        if not isinstance(text, str):
            raise TypeError(f"expected a text, got {type(text).__name__}")
        self.text = text
        self.functions = functions
        for name in functions:
            if not _place_of(name).search(text):
                raise ValueError(f"{name} is not in the expression {text!r}")

    def __repr__(self) -> str:
        return f"Expression({self.text!r})"

    def _add(self, session: _sphvar.Session, name: _Namer, energies: bool) -> str:
        parts = {
            key: _text(session, value, name, energies, key)
            for key, value in self.functions.items()
        }
        text = self.text
        if parts:
            any_name = re.compile("|".join(_place_of(key).pattern for key in parts))
            text = any_name.sub(lambda found: parts[found.group(0)], text)
        return text


#: An integrand: a name or expression of the command, a vectorized callable, an array of the values
#: of a HEALPix map, an image, complex coefficients, or one of the wrappers of this module.
IntegrandLike: TypeAlias = Union[
    str,
    Function,
    HealpixMap,
    Environment,
    Coefficients,
    Energies,
    Expression,
    VectorizedCallable,
    ArrayLike,
]


def add_integrand(
    session: _sphvar.Session, value: IntegrandLike, name: _Namer, *, energies: bool = True
) -> str:
    """Add an integrand to a session and return its text.

    Parameters
    ----------
    session
        The session.
    value
        The integrand.
    name
        Returns a free name.
    energies
        Whether energies are needed.

    Returns
    -------
    str
        The text of the integrand, such as ``"function:f"``.

    Raises
    ------
    TypeError, ValueError
        For objects that are no integrands, naming the wrappers where an array may mean several.
    """
    return _text(session, value, name, energies, None)


def _text(
    session: _sphvar.Session, value: Any, name: _Namer, energies: bool, label: str | None
) -> str:
    if isinstance(value, str):
        return value
    given = value if isinstance(value, Given) else _wrapped(value, label)
    return given._add(session, name, energies)


def _wrapped(value: Any, label: str | None) -> Given:
    """Return the wrapper that an object means by its type and shape."""
    named: dict[str, Any] = {} if label is None else {"name": label}
    if callable(value):
        return Function(value, **named)
    try:
        array: NDArray[Any] = np.asanyarray(value)
    except ValueError as error:
        raise ValueError(f"integrand: expected a text, a callable or an array: {error}") from None
    kind, shape = array.dtype.kind, array.shape
    if kind == "c" and array.ndim == 1 and _is_triangular(array.size):
        return Coefficients(array, **named)
    if kind in "fiu" and array.ndim == 1 and _is_map(array.size):
        return HealpixMap(array, **named)
    if kind in "fiu" and array.ndim in (2, 3) and shape[1] == 2 * shape[0] > 0:
        return Environment(array, **named)
    if kind not in "fiuc":
        raise TypeError(
            "integrand: expected a name or expression, a vectorized callable, an array, or a Function, "
            f"HealpixMap, Environment, Coefficients, Energies or Expression, "
            f"got {type(value).__name__}" + (f" of dtype {array.dtype}" if array.ndim else "")
        )
    raise ValueError(
        f"integrand: an array of dtype {array.dtype} and shape {shape} is neither a HEALPix map "
        "(12 nside**2,), nor an image (h, 2 h) or (h, 2 h, 3), nor complex coefficients in the order of "
        "healpy; say what it is: HealpixMap, Environment, Coefficients or Energies"
    )


def _real(name: str, values: ArrayLike) -> NDArray[np.float64]:
    array = unmasked(name, values)
    if array.dtype.kind not in "fiu" and array.size:
        raise TypeError(f"{name}: expected real numbers, got dtype {array.dtype}")
    return array.astype(np.float64, copy=False)


def _edge(axis: ArrayLike, angle: float) -> tuple[list[float], float]:
    x = np.asarray(axis, dtype=np.float64)
    if x.shape != (3,):
        raise ValueError(f"edges: expected an axis of shape (3,), got {x.shape}")
    return [float(part) for part in x], float(angle)


def _is_map(size: int) -> bool:
    nside = int(np.sqrt(size / 12) + 0.5)
    return nside > 0 and 12 * nside * nside == size


def _is_triangular(size: int) -> bool:
    lmax = int((np.sqrt(8 * size + 1) - 3) / 2 + 0.5)
    return lmax >= 0 and (lmax + 1) * (lmax + 2) // 2 == size


def _name_of(function: object) -> str:
    name = str(getattr(function, "__name__", type(function).__name__))
    return "the function" if name == "<lambda>" else name


def _word(label: str) -> str:
    """Return a label as a word of the grammar."""
    word = re.sub(r"\W+", "-", label, flags=re.ASCII).strip("-").removeprefix("the-")
    return word or "function"


def _place_of(name: str) -> re.Pattern[str]:
    """Return the pattern of a name where an expression has an integrand."""
    return re.compile(rf"(?:(?<![^\s\"'])|(?<=of=)){re.escape(name)}(?![^\s\"',])")
