"""Integrals to a tolerance, values and energies of integrands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, SupportsIndex, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar
from ._ask import checked, document, warn, words
from ._checks import reject_truth
from ._functions import Function, Given, IntegrandLike, add_integrand
from ._inputs import Inputs, SamplerLike, with_defaults
from ._progress import Progress, reporting
from ._results import Result


class Integral(Result):
    """An integral with its error, and the nodes that give it.

    Attributes
    ----------
    value : float or ndarray
        The integral; of shape (k,) for a callable with k values per direction.
    error : float or ndarray
        The half width of its 95 % interval; NaN where the values do not determine it.
    exact : float or None
        The exact integral, if it is known.
    converged : bool
        Whether the error is within the tolerance.
    message : str or None
        Why the tolerance is not met.
    stop : str
        Why the integration ended: ``"tolerance"``, ``"rounding"``, ``"max-points"``,
        ``"largest-set"`` or ``"equal-values"``.
    n, copies : int
        The points of each of the rotated copies of the last level, and the number of copies.
    evaluations : int
        The number of values at all levels.
    """

    _shown: ClassVar[tuple[str, ...]] = (
        "value",
        "error",
        "exact",
        "converged",
        "sampler",
        "n",
        "copies",
        "evaluations",
    )

    value: Any
    error: Any
    exact: float | None
    converged: bool
    message: str | None
    stop: str
    n: int
    copies: int
    evaluations: int

    def __init__(self, document: Mapping[str, Any], found: _sphvar.Integral) -> None:
        super().__init__(document)
        #: What gives the nodes, until they are needed.
        self._found: _sphvar.Integral | None = found
        self._rule: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

    def _nodes_and_weights(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        if self._rule is None:
            assert self._found is not None, "a result has what gives its nodes, or the nodes"
            self._rule = self._found.nodes()
        return self._rule

    def __getstate__(self) -> dict[str, Any]:
        return {"_document": self._document, "_rule": self._nodes_and_weights(), "_found": None}

    @property
    def nodes(self) -> NDArray[np.float64]:
        """The points of the last level, of shape (copies * n, 3).

        Examples
        --------
        >>> import numpy as np, sphvar
        >>> f = lambda points: np.exp(points[:, 0])
        >>> integral = sphvar.integrate(f)
        >>> bool(np.isclose(integral.weights @ f(integral.nodes), integral.value, rtol=1e-13))
        True
        """
        return self._nodes_and_weights()[0]

    @property
    def weights(self) -> NDArray[np.float64]:
        """The weights of the nodes, of shape (copies * n,); they sum to the area of the domain.

        Examples
        --------
        >>> import numpy as np, sphvar
        >>> bool(np.isclose(sphvar.integrate("cosine").weights.sum(), 4 * np.pi))
        True
        """
        return self._nodes_and_weights()[1]

    def __float__(self) -> float:
        return float(self._document["value"])


@checked
def integrate(
    integrand: IntegrandLike,
    *,
    rtol: Union[float, str, None] = None,
    atol: float | None = None,
    sampler: SamplerLike = "fibonacci",
    hemisphere: bool = False,
    max_points: int = 10_000_000,
    seed: int | None = None,
    progress: Progress = None,
) -> Integral:
    """Integrate a function over the sphere or the upper hemisphere to a tolerance.

    The value is the mean over 16 independently rotated copies of a set of N points. N doubles until
    the error, the half width of a 95 % interval from the spread of the copies, is at most
    ``max(atol, rtol * abs(value))``. A tolerance that is not met is a warning, and
    ``converged`` is false. The average over directions is the value divided by ``4 pi``, on the
    hemisphere by ``2 pi``.

    Parameters
    ----------
    integrand
        A vectorized callable on arrays of shape (n, 3), which may return several values per
        direction, of shape (n, k); or any other integrand.
    rtol
        The relative tolerance, such as 1e-4 or ``"0.01%"``; 1e-4 unless given, or none with ``atol``.
    atol
        The absolute tolerance, which an integral of 0 needs.
    sampler
        The sampler of the points. ``"lebedev"`` needs fewer values for smooth functions, but has no
        set of more than 5810 points.
    hemisphere
        Whether the domain is the hemisphere z >= 0; nothing is evaluated below.
    max_points
        The number of values not to exceed, summed over all copies and all N.
    seed
        The seed of rotations and random samplers; that of a `Sampler`, otherwise 0, by default.
    progress
        True for a bar of tqdm, or a callable of the work done and expected.

    Returns
    -------
    Integral
        The value, its error, and the nodes with their weights.

    Raises
    ------
    ValueError
        For invalid options; for a callable that returns the wrong shape or a value that is not
        finite, with the direction. Exceptions of the callable itself pass through with a note on the
        direction.

    Warns
    -----
    SphvarWarning
        If the tolerance is not met.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> integral = sphvar.integrate(lambda points: np.exp(points[:, 0]), rtol=1e-6)
    >>> integral.converged, bool(abs(integral.value - 4 * np.pi * np.sinh(1)) < 2 * integral.error)
    (True, True)

    The average over orientations of several functions, from the same points:

    >>> q = np.array([0.5, 1.0, 2.0])
    >>> squares = lambda points: np.cos(np.outer(points[:, 2], q)) ** 2
    >>> averages = sphvar.integrate(squares, sampler="lebedev").value / (4 * np.pi)
    >>> bool(np.allclose(averages, 0.5 + np.sin(2 * q) / (4 * q), rtol=1e-4))
    True
    """
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [integrand, sampler])
        text, vector, label = _values(session, integrand, inputs)
        samplers = inputs.samplers(sampler)
        if len(samplers) != 1:
            raise ValueError(f"sampler: expected one, got {len(samplers)}")
        options = {
            "integrand": text,
            "sampler": samplers[0],
            "rtol": rtol,
            "atol": atol,
            "max_points": max_points,
            "hemisphere": hemisphere,
            "seed": seed,
        }
        options = with_defaults(sampler, options)
        found = session.integrate(words("integrate", [], options), vector, label)
    body = document(found.document)
    body["message"] = found.failure
    values, errors = found.estimates()
    body["value"], body["error"] = values, errors
    if vector is None:
        body["value"], body["error"] = float(values[0]), float(errors[0])
    if found.failure is not None:
        warn(found.failure)
    for remark in body["remarks"]:
        warn(remark)
    return Integral(body, found)


def _values(
    session: _sphvar.Session, integrand: IntegrandLike, inputs: Inputs
) -> tuple[str, Any, str | None]:
    """Return the text of an integrand of which values suffice, and a callable of several values."""
    if callable(integrand) and not isinstance(integrand, Given):
        integrand = Function(integrand)
    if not isinstance(integrand, Function) or integrand.degree is not None:
        return add_integrand(session, integrand, inputs.name, energies=False), None, None
    name = inputs.name("function")
    components = session.add_values_function(name, integrand.function, integrand.name)
    text = f"function:{name}"
    return (text, None, None) if components is None else (text, integrand.function, integrand.name)


def evaluate(integrand: IntegrandLike, points: ArrayLike) -> NDArray[np.float64]:
    """Return the values of an integrand at points.

    Parameters
    ----------
    integrand
        The integrand.
    points
        Unit vectors of shape (n, 3), whose lengths may differ from 1 by up to 1e-6.

    Returns
    -------
    ndarray
        The values, of shape (n,).

    Examples
    --------
    >>> import sphvar
    >>> sphvar.evaluate("2 * cosine", [[0, 0, 1], [0.6, 0, 0.8], [0, 0, -1]])
    array([2. , 1.6, 0. ])
    """
    session = _sphvar.Session()
    inputs = Inputs(session, [integrand])
    text = add_integrand(session, integrand, inputs.name, energies=False)
    return session.evaluate(text, points)


def energies(
    integrand: IntegrandLike, lmax: SupportsIndex, *, hemisphere: bool = False
) -> NDArray[np.float64]:
    """Return the energies of an integrand per degree, ``E(l) = sum over m of |F_lm|**2``.

    Parameters
    ----------
    integrand
        The integrand.
    lmax
        The largest degree, from 0 to 1000000.
    hemisphere
        Whether they are those of the even extension from the hemisphere z >= 0.

    Returns
    -------
    ndarray
        The energies of degrees 0 to ``lmax``, of shape (lmax + 1,). Estimates for a callable whose
        values do not resolve it may end at a lower degree.

    Examples
    --------
    >>> import numpy as np, sphvar
    >>> np.round(sphvar.energies("ylm:l=2,m=1", 3), 12) + 0.0
    array([0., 0., 1., 0.])
    """
    session = _sphvar.Session()
    text = Inputs(session, [integrand]).integrand(integrand)
    reject_truth("lmax", lmax)
    return session.energies(text, lmax, bool(hemisphere))[0]
