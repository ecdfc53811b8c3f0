"""Which pattern of N directions gives the least integration error, and why."""

from ._sphvar import __version__, set_num_threads

__all__ = ["__version__", "set_num_threads"]
