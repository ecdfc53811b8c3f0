"""Which pattern of N directions gives the least integration error, and why.

Arrays in, arrays out: directions are unit vectors, float64 of shape (n, 3); a set of ``m``
realizations has shape (m, n, 3). Integrands are names and expressions, callables on directions,
HEALPix maps, images or coefficients; samplers are names with parameters, or arrays of points. Answers
are bit-identical to those of the command ``sphvar`` with the same seed.

Questions
    `choose`, `compare`, `predict`, `measure`, `variance`, `fixed_orientation`, `progressive`,
    `integrate`, `bounds`, `audit`, `quality`, `lights`.
Points and rotations
    `Sampler`, `list_samplers`, `list_warps`, `weights`, `rotations`, `rotation_quality`, `healpix`.
Integrands
    `Function`, `HealpixMap`, `Environment`, `Coefficients`, `Energies`, `Expression`,
    `list_integrands`, `evaluate`, `energies`.
Harmonics
    `spectrum`, `points2alm`, `alm2points`, `fit`.

Examples
--------
Which of three patterns of 100 directions integrates a function best, and how well?

>>> import numpy as np, sphvar
>>> def f(d):
...     return np.exp(d[:, 0])
>>> ranking = sphvar.choose(["white-noise", "jittered", "fibonacci"], integrand=f, n=100)
>>> ranking.sampler.tolist()
['fibonacci', 'jittered', 'white-noise']
"""

from . import healpix
from ._ask import SphvarWarning
from ._fits import Fit, QuadratureWeights, fit, weights
from ._functions import (
    Coefficients,
    Energies,
    Environment,
    Expression,
    Function,
    HealpixMap,
    IntegrandLike,
)
from ._inputs import SamplerLike, SamplersLike
from ._integrate import Integral, energies, evaluate, integrate
from ._lists import Entry, list_integrands, list_samplers, list_warps
from ._measures import audit, bounds, lights, quality, rotation_quality
from ._questions import (
    choose,
    compare,
    fixed_orientation,
    measure,
    predict,
    progressive,
    variance,
)
from ._results import (
    AuditResult,
    BoundsResult,
    ChoiceResult,
    ComparisonResult,
    LightsResult,
    ProgressiveResult,
    QualityResult,
    Result,
    RotationQualityResult,
    Table,
    VarianceResult,
)
from ._sampler import Sampler, rotations
from ._spectrum import Spectrum, SquareSpectrum, spectrum
from ._sphvar import __version__, set_num_threads
from ._transforms import alm2points, points2alm

__all__ = [
    "AuditResult",
    "BoundsResult",
    "ChoiceResult",
    "Coefficients",
    "ComparisonResult",
    "Energies",
    "Entry",
    "Environment",
    "Expression",
    "Fit",
    "Function",
    "HealpixMap",
    "Integral",
    "IntegrandLike",
    "LightsResult",
    "ProgressiveResult",
    "QuadratureWeights",
    "QualityResult",
    "Result",
    "RotationQualityResult",
    "Sampler",
    "SamplerLike",
    "SamplersLike",
    "Spectrum",
    "SphvarWarning",
    "SquareSpectrum",
    "Table",
    "VarianceResult",
    "__version__",
    "alm2points",
    "audit",
    "bounds",
    "choose",
    "compare",
    "energies",
    "evaluate",
    "fit",
    "fixed_orientation",
    "healpix",
    "integrate",
    "lights",
    "list_integrands",
    "list_samplers",
    "list_warps",
    "measure",
    "points2alm",
    "predict",
    "progressive",
    "quality",
    "rotation_quality",
    "rotations",
    "set_num_threads",
    "spectrum",
    "variance",
    "weights",
]
