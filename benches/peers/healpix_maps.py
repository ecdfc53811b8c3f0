"""Writes crates/cli/tests/data/*.fits: HEALPix maps of healpy that the tests of the command read.

Usage: python3 benches/peers/healpix_maps.py

Needs healpy (written with 1.20.1), for instance by `pip install healpy`.

Maps have nside 4 and the value p of pixel p counted in RING order, so that a reader who takes one order for
the other shows it; `unseen.fits` lacks the ring pixels 3 and 100, `partial.fits` (nside 16) has
the upper half of the pixels only. `smooth.fits` has nside 16 and the values 1 + z + x y at the centres.
"""

from pathlib import Path

import healpy as hp
import numpy as np

FOLDER = Path(__file__).resolve().parents[2] / "crates" / "cli" / "tests" / "data"
NSIDE = 4


def write(name, values, **options):
    hp.write_map(FOLDER / f"{name}.fits", values, overwrite=True, **options)


def main():
    FOLDER.mkdir(parents=True, exist_ok=True)
    ring = np.arange(12 * NSIDE**2, dtype=np.float64)
    write("ring", ring, nest=False, dtype=np.float64, coord="G")
    nested = hp.reorder(ring, r2n=True)
    write("nested", nested, nest=True, dtype=np.float32)
    write("two_fields", [ring, -ring], nest=False, dtype=np.float32)
    holes = ring.copy()
    holes[[3, 100]] = hp.UNSEEN
    write("unseen", holes, nest=False, dtype=np.float32)
    half = np.full(12 * 16**2, hp.UNSEEN)
    half[:1536] = 1.0
    write("partial", half, nest=False, dtype=np.float32, partial=True)
    x, y, z = hp.pix2vec(16, np.arange(hp.nside2npix(16)))
    write("smooth", 1.0 + z + x * y, nest=False, dtype=np.float64)


main()
