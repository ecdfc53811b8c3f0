"""Samplers and integrands of a call: texts as they are, arrays under names of their own."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeAlias, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _sphvar
from ._ask import document as document_of
from ._checks import unmasked
from ._functions import IntegrandLike, add_integrand
from ._sampler import Sampler

#: A sampler: a text such as ``"fibonacci"``, a `Sampler`, points of shape (n, 3) or sets of them of
#: shape (m, n, 3), or a tuple of points and weights of shape (n,) or (m, n).
SamplerLike: TypeAlias = Union[str, Sampler, ArrayLike, tuple[ArrayLike, ArrayLike]]

#: One or several samplers: a list of them, a text with commas, or a dictionary of them by labels,
#: which stand for the samplers in results. Items of a list are not typed, because type checkers take
#: lists of texts and arrays for lists of objects.
SamplersLike: TypeAlias = Union[SamplerLike, Sequence[Any], Mapping[str, SamplerLike]]

#: What to do with pairs of numbers where vectors are expected.
PAIRS_ADVICE = (
    "; sphvar.healpix.ang2vec makes vectors of angles (lonlat=True: of degrees), square=True takes points "
    "of the square"
)

_WORD = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


class Inputs:
    """The arrays of a call, in the session that answers it.

    Parameters
    ----------
    session
        The session to which arrays are added.
    values
        All values of the call that may contain texts. Names of arrays occur in none of them, so that
        no array hides a file.
    square
        Whether points are those of the unit square.
    """

    def __init__(self, session: _sphvar.Session, values: Iterable[Any], square: bool = False):
        self.session = session
        self._texts = list(_texts_of(values))
        self._names: set[str] = set()
        self._square = square
        self._labels: dict[str, str] = {}
        #: The labels of a dictionary in their order, and those of samplers by their texts.
        self._order: list[str] = []
        self._specs: dict[str, str] = {}
        self._counts: list[int] = []

    def samplers(self, value: SamplersLike | None) -> list[str]:
        """Return the texts of samplers."""
        if value is None:
            return []
        if isinstance(value, Mapping):
            if not value:
                raise ValueError("samplers: the dictionary is empty")
            texts = [self._sampler(one, str(label)) for label, one in value.items()]
            self._order = [str(label) for label in value]
            return texts
        ones = _several(value)
        if ones is None:
            return [self._sampler(value, None)]
        if not ones:
            raise ValueError("samplers: the list is empty")
        return [self._sampler(one, None) for one in ones]

    def others(self, value: SamplersLike) -> list[str]:
        """Return the texts of samplers of another option, whose rows have no labels of their own."""
        ones = list(value.values()) if isinstance(value, Mapping) else _several(value)
        return [self._sampler(one, None) for one in ([value] if ones is None else ones)]

    def integrand(self, value: IntegrandLike) -> str:
        """Return the text of an integrand."""
        if isinstance(value, str):
            return value
        return add_integrand(self.session, value, self.name)

    def count(self, n: Any) -> Any:
        """Return the numbers of points: those of the call, otherwise that of its `Sampler` objects."""
        if n is not None or not self._counts:
            return n
        counts = sorted(set(self._counts))
        if len(counts) > 1:
            numbers = ", ".join(map(str, counts))
            raise ValueError(f"n: missing, and the samplers have different ones: {numbers}")
        return counts

    def name(self, wanted: str) -> str:
        """Return a name that occurs in no text of the call: the wanted one, if it is a free word."""
        base = wanted if _WORD.fullmatch(wanted) else "array"
        name, number = base, 1
        while name in self._names or any(name in text for text in self._texts):
            number += 1
            name = f"{base}-{number}"
        self._names.add(name)
        return name

    def relabelled(self, answer: str) -> dict[str, Any]:
        """Return an answer as a document in which labels stand for samplers."""
        for text, label in sorted(self._labels.items(), key=lambda pair: -len(pair[0])):
            own = json.dumps(label, ensure_ascii=False)[1:-1]
            answer = re.sub(re.escape(text) + r"(?![A-Za-z0-9_-])", lambda _: own, answer)
        document = document_of(answer)
        rows = document.get("rows") or []
        found = list(dict.fromkeys(row["sampler"] for row in rows if "sampler" in row))
        is_ranked = bool(rows) and "rank" in rows[0]
        if not is_ranked and len(found) == len(self._order):
            # Rows are in the order of the samplers, whose texts may be shorter than those of rows.
            _rename(document, dict(zip(found, self._order)))
        else:
            _rename(document, self._specs)
        return document

    def _sampler(self, value: Any, label: str | None) -> str:
        parameters = ""
        if isinstance(value, Sampler):
            number, parameters, value = value.n, value._point_parameters, value.spec
            # Points have a number of their own.
            if isinstance(value, str):
                self._counts.append(number)
        if isinstance(value, str):
            if label is not None:
                self._specs[value] = label
            return value
        points, weights = _points(value, self._square)
        name = self.name(label if label is not None else "points")
        if self._square:
            self.session.add_square_points(name, points, weights)
        else:
            self.session.add_points(name, points, weights)
        text = f"file:{name}"
        self._labels[text] = label if label is not None else name
        if parameters:
            self._labels[text + parameters] = self._labels[text]
        return text + parameters


def with_defaults(samplers: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a call with those of its `Sampler` objects where it has none.

    Parameters
    ----------
    samplers
        The samplers of the call, as the user gave them.
    options
        The options. Of ``hemisphere`` and ``square`` those that the call has; a seed of ``None`` is that
        of the samplers, otherwise 0.

    Raises
    ------
    ValueError
        If the `Sampler` objects have different seeds or domains.
    """
    found = dict(options)
    own = list(_samplers_in(samplers))
    for name in ("hemisphere", "square"):
        if not found.get(name) and name in found and any(getattr(one, name) for one in own):
            if not all(getattr(one, name) for one in own):
                raise ValueError(f"{name}: missing, and only some samplers have it")
            found[name] = True
    if found.get("seed") is None:
        seeds = sorted({one.seed for one in own})
        if len(seeds) > 1:
            numbers = ", ".join(map(str, seeds))
            raise ValueError(f"seed: missing, and the samplers have different ones: {numbers}")
        found["seed"] = seeds[0] if seeds else 0
    return found


def _samplers_in(value: Any) -> Iterable[Sampler]:
    """Yield the `Sampler` objects of a call."""
    if isinstance(value, Sampler):
        yield value
    elif isinstance(value, Mapping):
        yield from _samplers_in(list(value.values()))
    elif isinstance(value, (list, tuple)):
        yield from (one for one in value if isinstance(one, Sampler))


def _rename(value: Any, labels: Mapping[str, str]) -> None:
    """Replace the names of samplers in a document, in place."""
    if isinstance(value, dict):
        for key, item in value.items():
            if isinstance(item, str):
                # Labels may be samplers of other labels, so each text is replaced once.
                value[key] = labels.get(item, item)
            else:
                _rename(item, labels)
    elif isinstance(value, list):
        for item in value:
            _rename(item, labels)


def _several(value: Any) -> list[Any] | None:
    """Return the samplers of a list or tuple; ``None`` for one sampler."""
    if isinstance(value, (str, Sampler, np.ndarray)) or not isinstance(value, (list, tuple)):
        return None
    if isinstance(value, tuple) and _is_weighted(value):
        return None
    is_sampler = [
        isinstance(one, (str, Sampler, tuple)) or np.ndim(one) >= 2 for one in value
    ]
    return list(value) if all(is_sampler) else None


def _is_weighted(value: tuple[Any, ...]) -> bool:
    """Return whether a tuple is one of points and weights: the second has one number per point."""
    if len(value) != 2 or any(isinstance(part, (str, Sampler, Mapping)) for part in value):
        return False
    shape = np.shape(value[0])
    return len(shape) >= 2 and np.ndim(value[1]) < len(shape)


def _points(value: Any, square: bool) -> tuple[NDArray[Any], NDArray[Any] | None]:
    """Return points of the right shape, and their weights."""
    weights: NDArray[Any] | None = None
    if isinstance(value, tuple) and _is_weighted(value):
        value, weights = value[0], unmasked("weights", value[1])
    try:
        points = unmasked("points", value)
    except ValueError as error:
        raise ValueError(f"points: expected an array, a text or a Sampler: {error}") from None
    if points.dtype.kind not in "fiu":
        raise TypeError(
            f"a sampler is a text, a Sampler or an array of points, "
            f"got {type(value).__name__} of dtype {points.dtype}"
        )
    size = 2 if square else 3
    if points.ndim not in (2, 3) or points.shape[-1] != size:
        is_pairs = not square and points.shape[-1:] == (2,)
        advice = PAIRS_ADVICE if is_pairs else ""
        raise ValueError(
            f"points: expected shape (n, {size}) or (m, n, {size}), got {points.shape}{advice}"
        )
    if weights is not None and weights.shape != points.shape[:-1]:
        raise ValueError(
            f"weights: expected shape {points.shape[:-1]}, one per point, got {weights.shape}"
        )
    return points, weights


def _texts_of(values: Iterable[Any]) -> Iterable[str]:
    """Yield all texts in values, lists and dictionaries of them."""
    for value in values:
        if isinstance(value, str):
            yield value
        elif isinstance(value, Sampler):
            yield from _texts_of([value.spec])
        elif isinstance(value, Mapping):
            yield from _texts_of(value.values())
        elif isinstance(value, (list, tuple)):
            yield from _texts_of(value)
