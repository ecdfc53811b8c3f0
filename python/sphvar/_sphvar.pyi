"""The native half of the package; its functions are private, and `sphvar` names the public ones."""

from collections.abc import Callable, Sequence
from typing import Any, SupportsIndex, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Integral",
    "NumberedSets",
    "Session",
    "SpectrumSums",
    "__version__",
    "_panic",
    "alm2points",
    "ang2pix",
    "check_memory",
    "fit",
    "npix2nside",
    "nside2npix",
    "pix2ang",
    "pix2vec",
    "points2alm",
    "quote",
    "reorder",
    "run_command",
    "set_num_threads",
    "spectrum",
    "vec2pix",
    "weights",
]

__version__: str

def run_command(words: Sequence[str]) -> int: ...
def set_num_threads(threads: int) -> None: ...
def quote(value: str) -> str: ...
@final
class Session:
    def __new__(cls, progress: Callable[[float, float], Any] | None = None) -> Session: ...
    def add_points(
        self,
        name: str,
        points: ArrayLike,
        weights: ArrayLike | None = None,
        values: ArrayLike | None = None,
        errors: ArrayLike | None = None,
    ) -> None: ...
    def add_square_points(
        self, name: str, points: ArrayLike, weights: ArrayLike | None = None
    ) -> None: ...
    def add_picture(self, name: str, texels: ArrayLike) -> None: ...
    def add_map(self, name: str, values: ArrayLike, nest: bool = False) -> None: ...
    def add_coefficients(self, name: str, alm: ArrayLike) -> None: ...
    def add_energies(
        self, name: str, energies: ArrayLike, errors: ArrayLike | None = None
    ) -> None: ...
    def add_spectrum(
        self, name: str, power: ArrayLike, stderr: ArrayLike, realizations: int
    ) -> None: ...
    def add_function(
        self,
        name: str,
        callable: Callable[..., Any],
        label: str,
        *,
        degree: int | None = None,
        edges: Sequence[tuple[Sequence[float], float]] | None = None,
        tolerance: float | None = None,
        min_evaluations: int | None = None,
        max_evaluations: int | None = None,
        hemisphere: bool = False,
    ) -> None: ...
    def add_values_function(
        self, name: str, callable: Callable[..., Any], label: str
    ) -> int | None: ...
    def answer(self, words: Sequence[str]) -> str: ...
    def remarks(self) -> list[str]: ...
    def evaluate(self, integrand: str, points: ArrayLike) -> NDArray[np.float64]: ...
    def energies(
        self, integrand: str, lmax: SupportsIndex, hemisphere: bool
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]: ...
    def integrate(
        self,
        words: Sequence[str],
        vector: Callable[..., Any] | None = None,
        label: str | None = None,
    ) -> Integral: ...

@final
class Integral:
    @property
    def document(self) -> str: ...
    @property
    def failure(self) -> str | None: ...
    def estimates(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
    def nodes(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

@final
class NumberedSets:
    def __new__(
        cls,
        kind: str,
        sampler: str,
        n: int | None,
        seed: int,
        hemisphere: bool,
        is_randomized: bool,
        nearest: bool,
        points: ArrayLike | None,
        weights: ArrayLike | None,
    ) -> NumberedSets: ...
    @property
    def sampler(self) -> str: ...
    @property
    def n_points(self) -> int: ...
    @property
    def n_given(self) -> int | None: ...
    @property
    def remarks(self) -> list[str]: ...
    def draw(
        self,
        first: int,
        count: int,
        in_order: bool,
        progress: Callable[[float, float], Any] | None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]: ...

@final
class SpectrumSums:
    @property
    def document(self) -> str: ...
    def merged(self, other: SpectrumSums) -> SpectrumSums: ...
    def to_bytes(self) -> bytes: ...
    @staticmethod
    def from_bytes(bytes: bytes) -> SpectrumSums: ...

def spectrum(
    session: Session, words: Sequence[str], part: tuple[int, int] | None = None
) -> SpectrumSums: ...
def weights(session: Session, words: Sequence[str]) -> tuple[str, NDArray[np.float64]]: ...
def fit(session: Session, words: Sequence[str]) -> tuple[str, NDArray[np.complex128]]: ...
def points2alm(
    points: ArrayLike,
    lmax: SupportsIndex,
    weights: ArrayLike | None = None,
    epsilon: float = 1e-12,
    method: str = "auto",
    progress: Callable[[float, float], Any] | None = None,
) -> NDArray[np.complex128]: ...
def alm2points(
    alm: ArrayLike,
    points: ArrayLike,
    lmax: SupportsIndex | None = None,
    epsilon: float = 1e-12,
    method: str = "auto",
    progress: Callable[[float, float], Any] | None = None,
) -> NDArray[np.float64]: ...
def vec2pix(nside: ArrayLike, x: ArrayLike, y: ArrayLike, z: ArrayLike, nest: bool) -> Any: ...
def pix2vec(nside: ArrayLike, ipix: ArrayLike, nest: bool) -> tuple[Any, Any, Any]: ...
def ang2pix(
    nside: ArrayLike, theta: ArrayLike, phi: ArrayLike, nest: bool, lonlat: bool
) -> Any: ...
def pix2ang(nside: ArrayLike, ipix: ArrayLike, nest: bool, lonlat: bool) -> tuple[Any, Any]: ...
def reorder(nside: ArrayLike, ipix: ArrayLike, to_nested: bool) -> Any: ...
def check_memory(name: str, len: int) -> None: ...
def nside2npix(nside: SupportsIndex) -> int: ...
def npix2nside(npix: SupportsIndex) -> int: ...
def _panic(in_pool: bool) -> None: ...
