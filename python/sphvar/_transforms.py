"""Transforms between scattered points and spherical-harmonic coefficients."""

from __future__ import annotations

from typing import Literal, SupportsIndex, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar
from ._checks import reject_truth
from ._progress import Progress, reporting

#: How coefficients are computed: ``exact``, by the definition and to rounding, ``fast``, to a
#: requested accuracy, or ``auto``, the one with less work.
Method: TypeAlias = Literal["auto", "exact", "fast"]


def points2alm(
    points: ArrayLike,
    lmax: SupportsIndex,
    *,
    weights: ArrayLike | None = None,
    epsilon: float = 1e-12,
    method: Method = "auto",
    progress: Progress = None,
) -> NDArray[np.complex128]:
    """Return the spherical-harmonic coefficients of weighted points.

    ``a_lm = sum_k w_k conj(Y_lm(x_k))`` with orthonormal harmonics and the Condon-Shortley phase, as
    in healpy and ``scipy.special.sph_harm_y``. This is the adjoint of `alm2points`, not its inverse.
    The power of n points in `spectrum` is ``4 pi / n`` times the mean of ``abs(a_lm)**2`` over m.

    Parameters
    ----------
    points : array_like
        Unit vectors of shape (n, 3), or m sets of them of shape (m, n, 3). Lengths may differ from 1
        by up to 1e-6. An array of float64 in C order is read in place: another thread must not
        change it during the call.
    lmax : int
        The largest degree.
    weights : array_like, optional
        Real numbers of any sign, of shape (n,), or (m, n) for m sets. All 1 by default.
    epsilon : float
        The accuracy of the fast method, from 1e-13 to 0.1: the error of the coefficients is at most
        `epsilon` times their norm, in the 2-norm; for weights of both signs, times the norm for
        their absolute values.
    method : {'auto', 'exact', 'fast'}
        By the definition in O(n lmax^2), or fast in O(n + lmax^3), or the one with less work.
    progress : bool or callable, optional
        True for a bar of tqdm, or a callable of the work done and expected.

    Returns
    -------
    numpy.ndarray
        Complex coefficients of shape ((lmax+1)(lmax+2)/2,) or (m, (lmax+1)(lmax+2)/2), for m >= 0 in
        the order of healpy: l = 0..lmax for m = 0, then l = 1..lmax for m = 1, and so on.

    Raises
    ------
    ValueError
        For other shapes, vectors that are not directions, numbers that are not finite, a degree
        above 1000000, or an epsilon out of range.
    TypeError
        For weights or points that are not real numbers.
    MemoryError
        Before the memory is taken.

    Examples
    --------
    Two opposite points have no odd degrees.

    >>> import numpy as np
    >>> import sphvar
    >>> alm = sphvar.points2alm([[0, 0, 1], [0, 0, -1]], 2)
    >>> np.round(alm.real, 4)
    array([0.5642, 0.    , 1.2616, 0.    , 0.    , 0.    ])
    """
    reject_truth("lmax", lmax)
    if progress is None:
        return _sphvar.points2alm(points, lmax, weights, epsilon, method)
    with reporting(progress) as report:
        return _sphvar.points2alm(points, lmax, weights, epsilon, method, report)


def alm2points(
    alm: ArrayLike,
    points: ArrayLike,
    *,
    lmax: SupportsIndex | None = None,
    epsilon: float = 1e-12,
    method: Method = "auto",
    progress: Progress = None,
) -> NDArray[np.float64]:
    """Return the values of a real function with given coefficients at scattered points.

    ``f(x) = sum_lm a_lm Y_lm(x)`` over ``-l <= m <= l``, with ``a_l,-m = (-1)^m conj(a_lm)``.

    Parameters
    ----------
    alm : array_like
        Coefficients for m >= 0 in the order of healpy, of shape ((lmax+1)(lmax+2)/2,). Imaginary
        parts for m = 0 have no effect.
    points : array_like
        Unit vectors of shape (..., 3), as those of `points2alm`.
    lmax : int, optional
        The largest degree of the coefficients, which their number determines.
    epsilon : float
        The accuracy of the fast method, from 1e-13 to 0.1: the error at a point is at most
        ``epsilon (lmax + 1) / sqrt(4 pi)`` times the 2-norm of all coefficients.
    method : {'auto', 'exact', 'fast'}
        As for `points2alm`.
    progress : bool or callable, optional
        True for a bar of tqdm, or a callable of the work done and expected.

    Returns
    -------
    numpy.ndarray
        The values, of the shape of the points without its last dimension.

    Raises
    ------
    ValueError
        For other shapes, vectors that are not directions, numbers that are not finite, or an epsilon
        out of range.
    MemoryError
        Before the memory is taken.

    Examples
    --------
    The harmonic Y_10 is ``sqrt(3 / (4 pi)) z``.

    >>> import sphvar
    >>> float(sphvar.alm2points([0, 1, 0], [[0.6, 0, 0.8]])[0]).__round__(4)
    0.3909
    """
    reject_truth("lmax", lmax)
    if progress is None:
        return _sphvar.alm2points(alm, points, lmax, epsilon, method)
    with reporting(progress) as report:
        return _sphvar.alm2points(alm, points, lmax, epsilon, method, report)
