"""The samplers, integrands and densities that have names."""

from __future__ import annotations

import html
from collections.abc import Iterator
from typing import Any, SupportsIndex

from . import _sphvar
from ._ask import ask


class Entry:
    """A sampler, an integrand or a density that has a name, with a summary and its parameters.

    Every key of the document of ``sphvar list --json`` is an attribute. ``print(entry)`` lists the
    parameters; lists of entries are printed as tables, also in notebooks.

    Parameters
    ----------
    document : dict
        The entry in the document of the command.

    Examples
    --------
    >>> import sphvar
    >>> entry = next(entry for entry in sphvar.list_samplers() if entry.name == "fibonacci")
    >>> entry.extensible
    False
    """

    __slots__ = ("_document",)

    def __init__(self, document: dict[str, Any]) -> None:
        self._document = document

    @property
    def name(self) -> str:
        """The name, as every function accepts it."""
        return str(self._document["name"])

    @property
    def summary(self) -> str:
        """What it is, in one sentence."""
        return str(self._document["summary"])

    @property
    def parameters(self) -> list[Entry]:
        """The parameters in their order, each with ``name``, ``summary``, ``range`` and ``default``."""
        return [Entry(parameter) for parameter in self._document["parameters"]]

    def __getattr__(self, name: str) -> Any:
        if not name.startswith("_") and name in self._document:
            return self._document[name]
        raise AttributeError(f"{self.name} has no {name!r}; there are {', '.join(self._document)}")

    def __dir__(self) -> Iterator[str]:
        yield from super().__dir__()
        yield from self._document

    def to_dict(self) -> dict[str, Any]:
        """Return the entry as a dictionary.

        Returns
        -------
        dict
            A copy of the entry of ``sphvar list --json``.
        """
        return dict(self._document)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Entry) and self._document == other._document

    def __hash__(self) -> int:
        return hash(self.name)

    def __reduce__(self) -> tuple[type[Entry], tuple[dict[str, Any]]]:
        return Entry, (self._document,)

    def __repr__(self) -> str:
        return f"<{self.name}: {self.summary}>"

    def __str__(self) -> str:
        lines = [f"{self.name}: {self.summary}"]
        for key, summary in self._described():
            lines.append(f"  {key}: {summary}")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        title = f"<caption>{html.escape(f'{self.name}: {self.summary}')}</caption>"
        return f"<table>{title}{_html_rows(self._described())}</table>"

    def _described(self) -> list[tuple[str, ...]]:
        """Return the parameters with their descriptions, ranges and defaults."""
        found: list[tuple[str, ...]] = []
        for parameter in self._document.get("parameters", []):
            default = parameter.get("default")
            ends = [parameter["summary"], parameter["range"]]
            ends += [] if default is None else [f"default {default}"]
            found.append((parameter["name"], "; ".join(ends)))
        return found


class _Entries(list[Entry]):
    """A list of entries that is printed as a table of their names, parameters and summaries."""

    def _cells(self) -> list[tuple[str, ...]]:
        return [
            (entry.name, ", ".join(part.name for part in entry.parameters), entry.summary)
            for entry in self
        ]

    def __repr__(self) -> str:
        cells = self._cells()
        wide = [max((len(row[i]) for row in cells), default=0) for i in range(2)]
        return "\n".join(
            f"{name:{wide[0]}}  {parameters:{wide[1]}}  {summary}".rstrip()
            for name, parameters, summary in cells
        )

    def _repr_html_(self) -> str:
        head = "<tr><th>name</th><th>parameters</th><th>summary</th></tr>"
        return f"<table>{head}{_html_rows(self._cells())}</table>"


def _html_rows(rows: list[tuple[str, ...]]) -> str:
    return "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
    )


_KINDS = {
    "sphere": ("samplers", "samplers", {}),
    "hemisphere": ("samplers", "samplers", {"hemisphere": True}),
    "square": ("samplers", "square_samplers", {"square": True}),
    "rotations": ("rotations", "rotations", {}),
}


def list_samplers(domain: str = "sphere", *, n: SupportsIndex | None = None) -> list[Entry]:
    """Return the samplers of a domain, from the declarations that the command ``sphvar list`` shows.

    Parameters
    ----------
    domain : {"sphere", "hemisphere", "square", "rotations"}, optional
        The domain of the points.
    n : int, optional
        The number of points for which the largest degree without power is given.

    Returns
    -------
    list of Entry
        With the attributes ``name``, ``summary``, ``parameters``, ``counts`` (the valid numbers of
        points in words), ``cost``, ``low_degrees``, ``smooth_rate``, ``jump_rate``, ``distribution``,
        ``deterministic``, ``extensible``, ``last_empty_degrees`` and ``source``.

    Notes
    -----
    The samplers of ``list_samplers("square")``, such as ``sobol``, also sample a density of directions by
    the parameter ``warp``: ``"sobol:warp=cosine"``. `list_warps` has the densities.

    Examples
    --------
    >>> import sphvar
    >>> "fibonacci" in [entry.name for entry in sphvar.list_samplers()]
    True
    >>> [entry.name for entry in sphvar.list_samplers("rotations")][:2]
    ['uniform', 'super-fibonacci']
    """
    if domain not in _KINDS:
        raise ValueError(f"domain must be {', '.join(_KINDS)}; got {domain!r}")
    kind, key, options = _KINDS[domain]
    return _entries(kind, key, {**options, "count": n})


def list_integrands(domain: str = "sphere") -> list[Entry]:
    """Return the integrands that have names.

    Parameters
    ----------
    domain : {"sphere", "square"}, optional
        The domain of the functions.

    Returns
    -------
    list of Entry
        With the attributes ``name``, ``summary``, ``example`` and ``parameters``.

    Examples
    --------
    >>> import sphvar
    >>> "vmf" in [entry.name for entry in sphvar.list_integrands()]
    True
    """
    if domain not in ("sphere", "square"):
        raise ValueError(f"domain must be sphere or square, got {domain!r}")
    is_square = domain == "square"
    key = "square_integrands" if is_square else "integrands"
    return _entries("integrands", key, {"square": is_square})


def list_warps() -> list[Entry]:
    """Return the densities that the parameter ``warp`` of samplers accepts.

    A sampler of the unit square, such as ``"sobol"`` or ``"halton"``, samples directions in proportion
    to the density and has weights for it: ``"sobol:warp=cosine"``, or ``'sobol:warp="vmf:kappa=20"'``
    with parameters. `lights` also accepts ``warp=luminance``, the luminance of its image.

    Returns
    -------
    list of Entry
        With the attributes ``name``, ``summary``, ``example`` and ``parameters``.

    Examples
    --------
    >>> import sphvar
    >>> "cosine" in [entry.name for entry in sphvar.list_warps()]
    True
    """
    return _entries("warps", "warps", {})


def _entries(kind: str, key: str, options: dict[str, Any]) -> list[Entry]:
    document = ask("list", [kind], options, _sphvar.Session(None))
    return _Entries(Entry(entry) for entry in document[key])
