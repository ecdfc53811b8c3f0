"""Points of a call: arrays in its session, or files by their paths."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, TypeAlias, Union

import numpy as np
from numpy.typing import ArrayLike

from ._checks import unmasked
from ._inputs import PAIRS_ADVICE, Inputs

#: The path of a file. A text is not one, because it may be the name of a sampler.
Path: TypeAlias = "os.PathLike[str]"

#: Points: an array of shape (n, 3), a tuple of points and weights, or the path of a file, or several.
PointsLike: TypeAlias = Union[Path, Sequence[Path], ArrayLike, tuple[ArrayLike, ArrayLike]]


def given_points(
    points: Any,
    inputs: Inputs,
    *,
    weights: ArrayLike | None = None,
    values: ArrayLike | None = None,
    errors: ArrayLike | None = None,
    square: bool = False,
) -> list[str]:
    """Return the names of points for the command, after arrays are added to the session.

    Parameters
    ----------
    points
        An array, a tuple of points and weights, or paths: `PointsLike`.
    inputs
        The names that the call uses, and its session.
    weights, values, errors
        A number for every point of an array.
    square
        Whether points are those of the unit square.

    Returns
    -------
    list of str
        The names, those of files in their order.
    """
    paths = _paths(points)
    if paths is not None:
        columns = {"weights": weights, "values": values, "errors": errors}
        for name, column in columns.items():
            if column is not None:
                raise ValueError(f"{name}: those of a file are a column of it; omit {name}")
        return paths
    if isinstance(points, str):
        raise TypeError(f"points: expected an array or a pathlib.Path, got the text {points!r}")
    if isinstance(points, tuple) and len(points) == 2 and np.ndim(points[0]) >= 2:
        if weights is not None:
            raise ValueError("weights: given with the points and as a keyword")
        points, weights = points
    points = unmasked("points", points)
    optional = {"weights": weights, "values": values, "errors": errors}
    weights, values, errors = (
        None if given is None else unmasked(name, given) for name, given in optional.items()
    )
    name = inputs.name("points")
    if square:
        inputs.session.add_square_points(name, points, weights)
    else:
        try:
            inputs.session.add_points(name, points, weights, values, errors)
        except ValueError as error:
            if np.shape(points)[-1:] != (2,):
                raise
            raise ValueError(f"{error}{PAIRS_ADVICE}") from None
    return [name]


def _paths(points: Any) -> list[str] | None:
    """Return the paths of files, or ``None`` for anything else."""
    several = points if isinstance(points, (list, tuple)) and points else [points]
    if not all(isinstance(one, os.PathLike) for one in several):
        return None
    paths = [os.fspath(one) for one in several]
    # What starts with a hyphen is an option of the command, or standard input.
    return [os.path.join(".", path) if path.startswith("-") else path for path in paths]
