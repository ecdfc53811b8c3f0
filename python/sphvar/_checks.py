"""Checks of arguments before anything is computed: whole numbers, and arrays without masks."""

from __future__ import annotations

import operator
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

#: The number of seeds, and of the sets of a sampler.
STREAMS: Final = 2**64

#: The largest degree of spherical harmonics.
MAX_DEGREE: Final = 1_000_000


def whole(name: str, value: Any, lowest: int = 0, largest: int | None = None) -> int:
    """Return a whole number in a range.

    Parameters
    ----------
    name
        The name of the argument in messages.
    value
        What was given.
    lowest, largest
        The range, including its ends; without an upper end by default.

    Returns
    -------
    int
        The number.

    Raises
    ------
    TypeError
        For anything but an integer; truth values are none.
    ValueError
        For a number out of range.
    """
    reject_truth(name, value)
    try:
        number = operator.index(value)
    except TypeError:
        what = f"{value!r}" if isinstance(value, (float, str)) else type(value).__name__
        raise TypeError(f"{name}: expected a whole number, got {what}") from None
    if largest is None and number < lowest:
        raise ValueError(f"{name} must be at least {lowest}, got {number}")
    if largest is not None and not lowest <= number <= largest:
        raise ValueError(f"{name} must be from {lowest} to {largest}, got {number}")
    return number


def reject_truth(name: str, value: Any) -> None:
    """Raise a TypeError for truth values, which old versions of numpy take as whole numbers."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: expected a whole number, got {value}")


def degree(name: str, value: Any) -> int:
    """Return a degree of spherical harmonics, from 0 to 1000000: `whole` in that range."""
    return whole(name, value, 0, MAX_DEGREE)


def seed_of(value: Any) -> int:
    """Return a seed, from 0 to 2**64 - 1: `whole` in that range."""
    return whole("seed", value, 0, STREAMS - 1)


def unmasked(name: str, value: Any) -> NDArray[Any]:
    """Return an array-like object as an array, without a copy where it is one.

    Parameters
    ----------
    name
        The name of the argument in messages.
    value
        What was given; a masked array must not have masked elements.

    Returns
    -------
    ndarray
        The array, no subclass.

    Raises
    ------
    ValueError
        For masked elements, whose numbers are not values.
    """
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        masked = int(np.ma.getmaskarray(value).sum())
        raise ValueError(
            f"{name}: {masked} of {value.size} elements are masked; pass those that are not, "
            "array.compressed() or array[~mask]"
        )
    return np.asarray(value)
