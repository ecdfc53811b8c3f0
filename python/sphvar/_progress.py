"""Progress through a callable, or a bar of tqdm."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias, Union

#: ``None`` or ``False``: no progress. ``True``: a bar, if tqdm is installed. A callable is given the
#: work done and the work expected, about 20 times a second; an exception that it raises stops the work.
Progress: TypeAlias = Union[bool, Callable[[float, float], Any], None]


@contextmanager
def reporting(progress: Progress) -> Iterator[Callable[[float, float], Any] | None]:
    """Yield the callable that the native module calls, and close a bar at the end."""
    if progress is None or progress is False:
        yield None
    elif progress is True:
        try:
            bars = importlib.import_module("tqdm.auto")
        except ImportError:
            yield None
            return
        with bars.tqdm(bar_format="{l_bar}{bar}| {elapsed}<{remaining}") as bar:

            def show(done: float, expected: float) -> None:
                bar.total = max(done, expected)
                bar.n = done
                bar.refresh()

            yield show
    elif callable(progress):
        yield progress
    else:
        raise TypeError(
            f"progress: expected True, None or a callable of the work done and expected, "
            f"got {type(progress).__name__}"
        )
