"""Writes the point catalogues and their spectrum in crates/cli/tests/data.

Usage: python3 benches/peers/point_catalogues.py

Needs numpy, scipy and astropy (written with 2.4.0, 1.17.0 and 7.2.0), for instance by `pip install`. The spectrum is a direct sum over points with the spherical harmonics
of scipy, P(l) = 4 pi sum_m |sum_k w_k conj Y_lm(x_k)|^2 / ((2 l + 1) sum_k w_k^2).
"""

import gzip
from pathlib import Path

import numpy as np
import scipy.special
from astropy.io import fits
from astropy.table import Table

OUT = Path(__file__).resolve().parents[2] / "crates" / "cli" / "tests" / "data"
LMAX = 24


def spectrum(ra, dec, w):
    theta, phi = np.radians(90 - dec), np.radians(ra)
    power = []
    for l in range(LMAX + 1):
        y = [np.sum(w * np.conj(scipy.special.sph_harm_y(l, m, theta, phi))) for m in range(-l, l + 1)]
        power.append(4 * np.pi * np.sum(np.abs(y) ** 2) / ((2 * l + 1) * np.sum(w**2)))
    return power


def catalogue():
    rng = np.random.default_rng(14)
    n = 120
    table = Table()
    table["RAJ2000"] = np.round(rng.uniform(0, 360, n), 9)
    table["DEJ2000"] = np.round(np.degrees(np.arcsin(rng.uniform(-1, 1, n))), 9)
    table["WEIGHT"] = np.round(rng.uniform(0.5, 2, n), 6)
    table["Z"] = np.round(rng.uniform(0, 1, n), 5)
    table.write(OUT / "catalogue.csv", overwrite=True)
    table.write(OUT / "catalogue.fits", overwrite=True)
    data = (OUT / "catalogue.fits").read_bytes()
    (OUT / "catalogue.fits.gz").write_bytes(gzip.compress(data, mtime=0))
    power = spectrum(table["RAJ2000"].data, table["DEJ2000"].data, table["WEIGHT"].data)
    lines = [f"{l},{p!r}" for l, p in enumerate(map(float, power))]
    (OUT / "catalogue_spectrum.csv").write_text("l,power\n" + "\n".join(lines) + "\n")


def kinds():
    """Columns of every type, in several HDUs: rows are the directions X, Y, Z of weights 1, 2, 65535."""
    ra = np.array([0.0, 90.0, 180.0])
    dec = np.array([0.0, 0.0, 90.0])
    weight = np.array([1, 2, 65535], dtype=np.uint16)
    variable = np.array([np.array([1.0]), np.array([1.0, 2.0]), np.array([])], dtype=object)
    # Angles in 16 bits, RA = 180 + 0.01 stored; the keywords follow below.
    stored = np.round((ra - 180) / 0.01).astype(np.int16)
    columns = [
        fits.Column("FLAGS", "3X", array=np.array([[1, 0, 0], [0, 1, 0], [1, 1, 1]], dtype=bool)),
        fits.Column("RA", "I", unit="deg", array=stored),
        fits.Column("DEC", "E", unit="deg", array=dec),
        fits.Column("W", "I", bzero=32768, array=weight),
        fits.Column("OK", "L", array=np.array([True, False, True])),
        fits.Column("VAR", "PD()", array=variable),
        fits.Column("POS", "3D", array=np.eye(3)),
        fits.Column("NAME", "6A", array=np.array(["one", "two", "one"])),
        fits.Column("ID", "K", null=-1, array=np.array([5, -1, 7])),
        fits.Column("C", "C", array=np.array([1j, 2j, 3j], dtype=np.complex64)),
        fits.Column("RADIANS", "D", unit="rad", array=np.radians(ra)),
    ]
    notes = fits.BinTableHDU.from_columns(
        [fits.Column("REMARK", "8A", array=np.array(["a", "b"]))], name="NOTES"
    )
    text = fits.TableHDU.from_columns(
        [
            fits.Column("RA", "F10.4", array=ra),
            fits.Column("DEC", "E15.7", array=dec),
            fits.Column("W", "I6", array=weight.astype(int)),
            fits.Column("NAME", "A4", array=np.array(["one", "two", "one"])),
        ],
        name="TEXT",
    )
    image = fits.PrimaryHDU(np.arange(6, dtype=np.int16).reshape(2, 3))
    table = fits.BinTableHDU.from_columns(columns, name="KINDS")
    table.header["TSCAL2"], table.header["TZERO2"] = 0.01, 180.0
    fits.HDUList([image, notes, table, text]).writeto(OUT / "kinds.fits", overwrite=True)


catalogue()
kinds()
