"""Quadrature weights of points, and fits of spherical harmonics to values at points."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar
from ._ask import checked, warn_of, words
from ._checks import degree as checked_degree
from ._given import PointsLike, given_points
from ._inputs import Inputs
from ._progress import Progress, reporting
from ._results import Result
from ._transforms import alm2points

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class QuadratureWeights(Result):
    """Quadrature weights of points, with their exactness, condition and range.

    An array for numpy: ``numpy.asarray(weights)`` and functions of numpy take it as `weights`.

    Attributes
    ----------
    n, n_distinct : int
        The number of points and of distinct ones; on the hemisphere antipodes are the same point.
    degree : int
        The degree to which the weights are exact.
    exact_degree : int
        The largest degree up to which the residual is at most 1e-11.
    nonnegative : bool
        Whether the weights are restricted to nonnegative ones.
    residual : float
        The largest ``abs(sum w Y_lm)`` of a degree from 1 to `degree`, relative to that of degree 0.
    condition : float
        The estimated condition number of the matrix of all harmonics up to `degree` at the points.
    min_weight, max_weight : float
        The smallest and the largest weight.
    n_effective : float
        ``(sum w)^2 / sum w^2``, the number of equally weighted points with the same noise.
    iterations : int
        The number of iterations of conjugate gradients.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown: ClassVar[tuple[str, ...]] = (
        "n",
        "degree",
        "exact_degree",
        "residual",
        "condition",
        "min_weight",
        "max_weight",
        "n_effective",
    )

    n: int
    n_distinct: int
    degree: int
    exact_degree: int
    nonnegative: bool
    residual: float
    condition: float
    min_weight: float
    max_weight: float
    n_effective: float
    iterations: int

    def __init__(self, document: Mapping[str, Any], weights: NDArray[np.float64]) -> None:
        super().__init__(document)
        self._weights = weights

    @property
    def weights(self) -> NDArray[np.float64]:
        """The weights in the order of the points; their sum is 4 pi, or 2 pi on the hemisphere.

        Examples
        --------
        >>> import numpy as np
        >>> import sphvar
        >>> octahedron = np.vstack([np.eye(3), -np.eye(3)])
        >>> bool(np.allclose(sphvar.weights(octahedron, degree=3).weights, 4 * np.pi / 6))
        True
        """
        return self._weights

    def to_dict(self) -> dict[str, Any]:
        """Return the document of ``sphvar weights --json``.

        Examples
        --------
        >>> import sphvar
        >>> len(sphvar.weights([[0, 0, 1], [0, 0, -1]], degree=1).to_dict()["weights"])
        2
        """
        document = super().to_dict()
        provenance = document.pop("provenance")
        return {**document, "weights": self._weights.tolist(), "provenance": provenance}

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array(self._weights, dtype) if copy else np.asarray(self._weights, dtype)

    def __len__(self) -> int:
        return len(self._weights)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, QuadratureWeights):
            return NotImplemented
        return super().__eq__(other) is True and np.array_equal(self._weights, other._weights)

    __hash__ = None


class Fit(Result):
    """A least-squares fit of spherical harmonics to values at points.

    Attributes
    ----------
    n, n_distinct : int
        The number of points, and of distinct ones of positive weight.
    lmax : int
        The largest degree.
    ridge : float
        The factor of the sum of squared coefficients in the minimized sum.
    residual_rms : float
        The root mean square of the residuals, weighted by the weights.
    noise_variance : float or None
        The variance of the noise of a value of weight 1, with `sigma` the reduced chi-square;
        ``None`` without degrees of freedom.
    degrees_of_freedom : float
        The number of points of positive weight minus that of coefficients, and what a ridge adds.
    condition : float
        The estimated condition number of the least-squares problem.
    iterations : int
        The number of iterations of conjugate gradients.
    provenance : dict
        The question in words of the command, the version and the seed.
    """

    _shown: ClassVar[tuple[str, ...]] = (
        "n",
        "lmax",
        "ridge",
        "residual_rms",
        "noise_variance",
        "degrees_of_freedom",
        "condition",
    )

    n: int
    n_distinct: int
    lmax: int
    ridge: float
    residual_rms: float
    noise_variance: float | None
    degrees_of_freedom: float
    condition: float
    iterations: int

    def __init__(self, document: Mapping[str, Any], alm: NDArray[np.complex128]) -> None:
        super().__init__(document)
        self._alm = alm

    @property
    def alm(self) -> NDArray[np.complex128]:
        """The coefficients, for m >= 0 in the order of healpy, as those of `points2alm`.

        Examples
        --------
        >>> import numpy as np
        >>> import sphvar
        >>> octahedron = np.vstack([np.eye(3), -np.eye(3)])
        >>> sphvar.fit(octahedron, octahedron[:, 2], 1).alm.shape
        (3,)
        """
        return self._alm

    @property
    def energies(self) -> NDArray[np.float64]:
        """The energy of each degree, ``sum_m abs(a_lm)^2``, without the mean energy of the noise.

        An unbiased estimate, which may be negative; NaN if the noise is unknown.

        Examples
        --------
        >>> import sphvar
        >>> points = sphvar.Sampler("fibonacci", 100).random(1)[0]
        >>> energies = sphvar.fit(points, points[:, 2] ** 2, 3).energies
        >>> bool(abs(energies[1]) < 1e-12 < energies[2])
        True
        """
        return self._energies("energy")

    @property
    def energies_stderr(self) -> NDArray[np.float64]:
        """The standard error of `energies`; NaN if the noise is unknown.

        Examples
        --------
        >>> import sphvar
        >>> points = sphvar.Sampler("fibonacci", 100).random(1)[0]
        >>> sphvar.fit(points, points[:, 2], 3).energies_stderr.shape
        (4,)
        """
        return self._energies("stderr")

    @property
    def noise_energies(self) -> NDArray[np.float64]:
        """The mean energy of the noise in each degree; NaN if it is unknown.

        Examples
        --------
        >>> import sphvar
        >>> points = sphvar.Sampler("fibonacci", 100).random(1)[0]
        >>> sphvar.fit(points, points[:, 2], 3).noise_energies.shape
        (4,)
        """
        return self._energies("noise")

    def _energies(self, key: str) -> NDArray[np.float64]:
        rows = self._document["energies"]
        return np.array([np.nan if row[key] is None else row[key] for row in rows])

    def eval(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return the values of the fit at directions.

        Parameters
        ----------
        points : array_like
            Unit vectors of shape (..., 3).

        Returns
        -------
        numpy.ndarray
            The values, of the shape of the points without its last dimension.

        Examples
        --------
        >>> import numpy as np
        >>> import sphvar
        >>> octahedron = np.vstack([np.eye(3), -np.eye(3)])
        >>> fit = sphvar.fit(octahedron, 2 + octahedron[:, 2], 1)
        >>> np.round(fit.eval([[0, 0.6, 0.8], [1, 0, 0]]), 8)
        array([2.8, 2. ])
        """
        return alm2points(self._alm, points)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Plot the energy of every degree with its standard error, and that of the noise.

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
        >>> points = sphvar.Sampler("fibonacci", 100).random(1)[0]
        >>> axes = sphvar.fit(points, points[:, 2], 3).plot()
        """
        from . import _plots

        axes = _plots.axes(ax)
        l = np.arange(self.lmax + 1)
        bars = np.nan_to_num(self.energies_stderr)
        colour, _ = _plots.style(axes)
        axes.errorbar(l, self.energies, bars, color=colour, fmt=".", label="function")
        axes.plot(l, self.noise_energies, color=_plots.style(axes)[0], label="noise")
        if (self.energies > 0).any():
            axes.set_yscale("log", nonpositive="mask")
        axes.set_xlabel("degree l")
        axes.set_ylabel("energy")
        _plots.legend(axes)
        return axes

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Fit):
            return NotImplemented
        return super().__eq__(other) is True and np.array_equal(self._alm, other._alm)

    __hash__ = None


@checked
def weights(
    points: PointsLike,
    *,
    degree: int | None = None,
    nonnegative: bool = False,
    hemisphere: bool = False,
    columns: str | None = None,
    hdu: int | str | None = None,
    join: bool = False,
    skip_invalid: bool = False,
    normalize: bool = False,
    progress: Progress = None,
) -> QuadratureWeights:
    """Return quadrature weights of points that are exact to a degree.

    Sums of the weights times a spherical harmonic are the integrals of all harmonics up to the
    degree. Of all such weights, those of the least sum of squares are computed.

    Parameters
    ----------
    points : array_like or path
        Unit vectors of shape (n, 3), or a `pathlib.Path` of a file of points.
    degree : int, optional
        The degree to which the weights are exact; the largest that converges by default. Degree t
        needs at least (t + 1)^2 points, or the points of a rule of that degree.
    nonnegative : bool
        Compute weights of at least 0.
    hemisphere : bool
        Use the hemisphere z >= 0, where only even degrees count.
    columns, hdu, join, skip_invalid, normalize
        How files are read, as the options of ``sphvar weights``.
    progress : bool or callable, optional
        True for a bar of tqdm, or a callable of the work done and expected.

    Returns
    -------
    QuadratureWeights
        The weights as ``.weights``, with their residual and condition number. Functions of numpy
        take it as an array.

    Raises
    ------
    ValueError
        For a value that is not valid, in the words of the command.
    RuntimeError
        If there are no such weights, or if they do not converge.

    Examples
    --------
    >>> import numpy as np
    >>> import sphvar
    >>> points = sphvar.Sampler("white-noise", 100).random(1)[0]
    >>> w = sphvar.weights(points, degree=4)
    >>> bool(np.abs(sphvar.points2alm(points, 4, weights=w)[1:]).max() < 1e-10)
    True
    """
    options = dict(
        degree=None if degree is None else checked_degree("degree", degree),
        nonnegative=nonnegative,
        hemisphere=hemisphere,
        columns=columns,
        hdu=hdu,
        join=join,
        skip_invalid=skip_invalid,
        normalize=normalize,
    )
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        files = given_points(points, Inputs(session, []))
        question = words("weights", [], options)
        document, array = _sphvar.weights(session, [*question, *files])
        warn_of(session)
    return QuadratureWeights(json.loads(document), array)


@checked
def fit(
    points: PointsLike,
    values: ArrayLike | None,
    lmax: int,
    *,
    weights: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
    ridge: float = 0.0,
    hemisphere: bool = False,
    columns: str | None = None,
    hdu: int | str | None = None,
    join: bool = False,
    skip_invalid: bool = False,
    normalize: bool = False,
    progress: Progress = None,
) -> Fit:
    """Return the least-squares fit of spherical harmonics to values at points.

    The coefficients minimize ``sum_k w_k (y_k - f(x_k))^2 + ridge sum_lm abs(a_lm)^2``. Their
    energies are corrected for the noise, whose variance the residuals give.

    Parameters
    ----------
    points : array_like or path
        Unit vectors of shape (n, 3), or a `pathlib.Path` of a file with values.
    values : array_like or None
        The values, of shape (n,); ``None`` for a file.
    lmax : int
        The largest degree. It needs at least (lmax + 1)^2 distinct points, without large gaps.
    weights : array_like, optional
        Weights of the values, inverse variances up to a common factor, of shape (n,).
    sigma : array_like, optional
        Standard errors of the values, in place of weights: the weights are ``1 / sigma^2``.
    ridge : float
        The factor of the sum of squared coefficients; the mean eigenvalue of the normal equations is
        ``sum w / (4 pi)``. It shrinks coefficients that the points do not determine.
    hemisphere : bool
        Use the hemisphere z >= 0, where only even degrees exist.
    columns, hdu, join, skip_invalid, normalize
        How files are read, as the options of ``sphvar fit``.
    progress : bool or callable, optional
        True for a bar of tqdm, or a callable of the work done and expected.

    Returns
    -------
    Fit
        The coefficients as ``.alm``, with energies, residuals and the noise.

    Raises
    ------
    ValueError
        For a value that is not valid, in the words of the command.
    RuntimeError
        If the points do not determine the coefficients.

    Examples
    --------
    >>> import numpy as np
    >>> import sphvar
    >>> points = sphvar.Sampler("fibonacci", 100).random(1)[0]
    >>> fit = sphvar.fit(points, 1 + points[:, 2], 4)
    >>> np.round(fit.alm[:2].real / np.sqrt(4 * np.pi * np.array([1, 1 / 3])), 8)
    array([1., 1.])
    """
    options = dict(
        lmax=checked_degree("lmax", lmax),
        ridge=ridge,
        hemisphere=hemisphere,
        columns=columns,
        hdu=hdu,
        join=join,
        skip_invalid=skip_invalid,
        normalize=normalize,
    )
    with reporting(progress) as report:
        session = _sphvar.Session(report)
        inputs = Inputs(session, [])
        files = given_points(points, inputs, weights=weights, values=values, errors=sigma)
        question = words("fit", [], options)
        document, alm = _sphvar.fit(session, [*question, *files])
        warn_of(session)
    return Fit(json.loads(document), alm)
