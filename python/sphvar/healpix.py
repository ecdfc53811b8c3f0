"""HEALPix pixels of directions and back, with the signatures of healpy.

Ring order exists for every nside from 1 to 2**29, nested order for powers of two. Arrays broadcast, and
may have any shape, strides and numeric type; the result for scalars is a scalar. Unlike in healpy, an
invalid value raises a ``ValueError`` with the first such value and its index.

Examples
--------
>>> from sphvar import healpix
>>> int(healpix.vec2pix(64, 0.0, 0.0, 1.0))
0
>>> healpix.pix2ang(1, range(12))[0].round(3).tolist()[::4]
[0.841, 1.571, 2.301]
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar as _healpix

__all__ = [
    "ang2pix",
    "ang2vec",
    "nest2ring",
    "npix2nside",
    "nside2npix",
    "pix2ang",
    "pix2vec",
    "ring2nest",
    "vec2ang",
    "vec2pix",
]


def vec2pix(nside: ArrayLike, x: ArrayLike, y: ArrayLike, z: ArrayLike, nest: bool = False) -> Any:
    """Return the pixels that contain directions.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, from 1 to 2**29; a power of two in nested order.
    x, y, z : array_like
        The components of vectors of any length other than 0.
    nest : bool, optional
        Number pixels in nested order instead of ring order.

    Returns
    -------
    int or ndarray of int64
        Pixels from 0, in the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For a vector without direction, with its index, and for an invalid nside.

    Examples
    --------
    >>> from sphvar import healpix
    >>> healpix.vec2pix(16, [1, 0, 0], [0, 1, 0], [0, 0, 1]).tolist()
    [1504, 1520, 0]
    """
    return _of_nside(
        lambda nside, x, y, z: _healpix.vec2pix(nside, x, y, z, nest), nside, x, y, z
    )


def pix2vec(nside: ArrayLike, ipix: ArrayLike, nest: bool = False) -> tuple[Any, Any, Any]:
    """Return the unit vectors of the centres of pixels.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, from 1 to 2**29; a power of two in nested order.
    ipix : int or array_like of int
        Pixels from 0 to 12 nside^2 - 1.
    nest : bool, optional
        Pixels are numbered in nested order instead of ring order.

    Returns
    -------
    x, y, z : float or ndarray
        The components, each in the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For a pixel out of range, with its index, and for an invalid nside.

    Examples
    --------
    >>> from sphvar import healpix
    >>> x, y, z = healpix.pix2vec(1, 4)
    >>> float(x), float(y), float(z)
    (1.0, 0.0, 0.0)
    """
    call = _of_nside(lambda nside, pixels: _healpix.pix2vec(nside, pixels, nest), nside, ipix)
    return call[0], call[1], call[2]


def ang2pix(
    nside: ArrayLike, theta: ArrayLike, phi: ArrayLike, nest: bool = False, lonlat: bool = False
) -> Any:
    """Return the pixels that contain directions given by angles.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, from 1 to 2**29; a power of two in nested order.
    theta, phi : array_like
        Colatitude from 0 to pi and longitude in radians or, with `lonlat`, longitude and latitude in
        degrees. A colatitude above pi by no more than 1e-6, as rounding to float32 has, is pi.
    nest : bool, optional
        Number pixels in nested order instead of ring order.
    lonlat : bool, optional
        Angles are longitude and latitude in degrees.

    Returns
    -------
    int or ndarray of int64
        Pixels from 0, in the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For an angle out of range, with its index, and for an invalid nside.

    Examples
    --------
    >>> from sphvar import healpix
    >>> int(healpix.ang2pix(256, 13.4, 52.5, lonlat=True))
    81234
    """
    return _of_nside(
        lambda nside, first, second: _healpix.ang2pix(nside, first, second, nest, lonlat),
        nside,
        theta,
        phi,
    )


def pix2ang(
    nside: ArrayLike, ipix: ArrayLike, nest: bool = False, lonlat: bool = False
) -> tuple[Any, Any]:
    """Return the angles of the centres of pixels.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, from 1 to 2**29; a power of two in nested order.
    ipix : int or array_like of int
        Pixels from 0 to 12 nside^2 - 1.
    nest : bool, optional
        Pixels are numbered in nested order instead of ring order.
    lonlat : bool, optional
        Return longitude and latitude in degrees.

    Returns
    -------
    theta, phi : float or ndarray
        Colatitude and longitude in radians, or longitude and latitude in degrees with `lonlat`, each
        in the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For a pixel out of range, with its index, and for an invalid nside.

    Examples
    --------
    >>> from sphvar import healpix
    >>> lon, lat = healpix.pix2ang(1, 0, lonlat=True)
    >>> round(float(lon), 3), round(float(lat), 3)
    (45.0, 41.81)
    """
    call = _of_nside(lambda nside, pixels: _healpix.pix2ang(nside, pixels, nest, lonlat), nside, ipix)
    return call[0], call[1]


def ring2nest(nside: ArrayLike, ipix: ArrayLike) -> Any:
    """Return the numbers in nested order of pixels that are numbered in ring order.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, a power of two up to 2**29.
    ipix : int or array_like of int
        Pixels in ring order, from 0 to 12 nside^2 - 1.

    Returns
    -------
    int or ndarray of int64
        Pixels in nested order, in the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For a pixel out of range, with its index, and for an invalid nside.

    Examples
    --------
    >>> from sphvar import healpix
    >>> healpix.ring2nest(2, range(6)).tolist()
    [3, 7, 11, 15, 2, 1]
    """
    return _of_nside(lambda nside, pixels: _healpix.reorder(nside, pixels, True), nside, ipix)


def nest2ring(nside: ArrayLike, ipix: ArrayLike) -> Any:
    """Return the numbers in ring order of pixels that are numbered in nested order.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, a power of two up to 2**29.
    ipix : int or array_like of int
        Pixels in nested order, from 0 to 12 nside^2 - 1.

    Returns
    -------
    int or ndarray of int64
        Pixels in ring order, in the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For a pixel out of range, with its index, and for an invalid nside.

    Examples
    --------
    >>> from sphvar import healpix
    >>> healpix.nest2ring(2, [3, 7, 11, 15, 2, 1]).tolist()
    [0, 1, 2, 3, 4, 5]
    """
    return _of_nside(lambda nside, pixels: _healpix.reorder(nside, pixels, False), nside, ipix)


def ang2vec(theta: ArrayLike, phi: ArrayLike, lonlat: bool = False) -> NDArray[np.float64]:
    """Return unit vectors of angles, the form in which this package takes points.

    Parameters
    ----------
    theta, phi : array_like
        Colatitude from 0 to pi and longitude in radians or, with `lonlat`, longitude (right ascension)
        and latitude (declination) in degrees.
    lonlat : bool, optional
        Angles are longitude and latitude in degrees.

    Returns
    -------
    ndarray
        Unit vectors of shape (..., 3), where ``...`` is the shape to which the arguments broadcast.

    Raises
    ------
    ValueError
        For a colatitude or latitude out of range and for angles that are not finite, with the index of
        the first.

    Examples
    --------
    >>> from sphvar import healpix
    >>> healpix.ang2vec([0, 90], [0, 90], lonlat=True).round(3).tolist()
    [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    """
    first, second = np.broadcast_arrays(np.asarray(theta, np.float64), np.asarray(phi, np.float64))
    polar, azimuth = (second, first) if lonlat else (first, second)
    low, high, unit = (-90.0, 90.0, "degrees") if lonlat else (0.0, np.pi, "radians")
    is_valid = (polar >= low) & (polar <= high) & np.isfinite(azimuth)
    if not is_valid.all():
        index = np.unravel_index(int(np.argmin(is_valid)), is_valid.shape)
        at = "".join(f"[{i}]" for i in index)
        names = ("latitude", "longitude") if lonlat else ("theta", "phi")
        raise ValueError(
            f"{names[0]}{at}: expected {names[0]} from {low:.6g} to {high:.6g} {unit} and a finite "
            f"{names[1]}, got {polar[index]} and {azimuth[index]}"
        )
    if lonlat:
        polar, azimuth = np.radians(polar), np.radians(azimuth)
        radius, height = np.cos(polar), np.sin(polar)
    else:
        radius, height = np.sin(polar), np.cos(polar)
    return np.stack([radius * np.cos(azimuth), radius * np.sin(azimuth), height], axis=-1)


def vec2ang(vectors: ArrayLike, lonlat: bool = False) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the angles of vectors.

    Parameters
    ----------
    vectors : array_like
        Vectors of any length other than 0, of shape (3,) or (..., 3).
    lonlat : bool, optional
        Return longitude and latitude in degrees.

    Returns
    -------
    theta, phi : ndarray
        Colatitude from 0 to pi and longitude from 0 to 2 pi or, with `lonlat`, longitude from 0 to 360
        and latitude in degrees; flat arrays with one entry a vector, as in healpy.

    Raises
    ------
    ValueError
        For other shapes, and for a vector without direction, with its index.

    Examples
    --------
    >>> from sphvar import healpix
    >>> longitude, latitude = healpix.vec2ang([[0, -1, 0], [0, 0, 2]], lonlat=True)
    >>> longitude.tolist(), latitude.tolist()
    ([270.0, 0.0], [0.0, 90.0])
    """
    v = np.asarray(vectors, dtype=np.float64)
    if v.ndim < 1 or v.shape[-1] != 3:
        raise ValueError(f"vectors: expected shape (3,) or (..., 3), got {v.shape}")
    x, y, z = v.reshape(-1, 3).T
    has_direction = np.isfinite(x + y + z) & ((x != 0) | (y != 0) | (z != 0))
    if not has_direction.all():
        index = int(np.argmin(has_direction))
        raise ValueError(f"vectors[{index}]: expected a direction, got {v.reshape(-1, 3)[index].tolist()}")
    longitude = np.arctan2(y, x) % (2 * np.pi)
    radius = np.hypot(x, y)
    if lonlat:
        return np.degrees(longitude), np.degrees(np.arctan2(z, radius))
    return np.arctan2(radius, z), longitude


def nside2npix(nside: ArrayLike) -> Any:
    """Return the number of pixels, 12 nside^2.

    Parameters
    ----------
    nside : int or array_like of int
        The resolution, from 1 to 2**29.

    Returns
    -------
    int or ndarray of int64
        The number of pixels of each resolution.

    Raises
    ------
    ValueError
        For an nside out of range.

    Examples
    --------
    >>> from sphvar import healpix
    >>> healpix.nside2npix(18)
    3888
    """
    return _each(_healpix.nside2npix, nside)


def npix2nside(npix: ArrayLike) -> Any:
    """Return the resolution with a number of pixels.

    Parameters
    ----------
    npix : int or array_like of int
        Numbers of pixels, 12 nside^2.

    Returns
    -------
    int or ndarray of int64
        The resolution of each number of pixels.

    Raises
    ------
    ValueError
        For a number that is not 12 nside^2, with the nearest one.

    Examples
    --------
    >>> from sphvar import healpix
    >>> healpix.npix2nside(3888)
    18
    """
    return _each(_healpix.npix2nside, npix)


def _of_nside(function: Callable[..., Any], nside: ArrayLike, *arrays: ArrayLike) -> Any:
    """Call a function of one nside, or once for each value of an array of them."""
    if isinstance(nside, int) or np.ndim(nside) == 0:
        return function(nside, *arrays)
    all_nsides, *others = np.broadcast_arrays(np.asarray(nside), *arrays)
    if all_nsides.size == 0:
        return function(1, *others)
    results: Any = None
    for value in np.unique(all_nsides):
        chosen = all_nsides == value
        part = function(value, *(other[chosen] for other in others))
        columns = part if isinstance(part, (tuple, list)) else [part]
        if results is None:
            results = [np.empty(all_nsides.shape, column.dtype) for column in columns]
        for result, column in zip(results, columns):
            result[chosen] = column
    return results if len(results) > 1 else results[0]


def _each(function: Callable[[Any], int], values: ArrayLike) -> Any:
    if isinstance(values, int) or np.ndim(values) == 0:
        return function(values)
    array = np.asarray(values)
    results = np.array([function(value) for value in array.flat], dtype=np.int64)
    return results.reshape(array.shape)
