"""Writes the HEALPix maps in unusual layouts and the coefficients that the tests of files read, and prints their values.

Run with healpy and astropy; the argument is the folder `crates/cli/tests/data`.
"""

import sys
from pathlib import Path

import healpy as hp
import numpy as np
from astropy.io import fits

folder = Path(sys.argv[1])
NSIDE = 4
N = hp.nside2npix(NSIDE)


def keywords(table, order="RING", **more):
    cards = {"PIXTYPE": "HEALPIX", "ORDERING": order, "NSIDE": NSIDE, **more}
    for key, value in cards.items():
        table.header[key] = value


def write(name, *hdus):
    fits.HDUList([fits.PrimaryHDU(), *hdus]).writeto(folder / name, overwrite=True)


rng = np.random.default_rng(14)
# A table that is no map, then one with bits, logicals, integers with a scale, a zero and a null, and bytes.
stars = fits.BinTableHDU.from_columns([fits.Column("RA", "D", array=[1.0, 2.0])], name="STARS")
bits = rng.integers(0, 2, (N, 3)).astype(bool)
counts = rng.integers(-100, 100, N).astype(np.int16)
counts[[5, 17]] = -999
mixed = fits.BinTableHDU.from_columns(
    [
        fits.Column("FLAGS", "3X", array=bits),
        fits.Column("MASK", "L", array=np.arange(N) % 3 == 0),
        fits.Column("COUNTS", "I", array=counts, null=-999),
        fits.Column("LEVEL", "B", array=np.arange(N).astype(np.uint8)),
        fits.Column("BIG", "K", array=np.arange(N) * 2**40),
    ],
    name="MAP",
)
keywords(mixed, INDXSCHM="IMPLICIT", FIRSTPIX=0, LASTPIX=N - 1)
mixed.header["TSCAL3"] = 0.5
mixed.header["TZERO3"] = 10.0
write("mixed.fits", stars, mixed)
values = np.where(counts == -999, np.nan, counts * 0.5 + 10.0)
print("mixed: COUNTS sum", np.nansum(values), "first", values[:3])

# Explicit indexing, nested order, with a column before the pixels.
pixels = rng.permutation(N)[:100].astype(np.int32)
explicit = fits.BinTableHDU.from_columns(
    [
        fits.Column("PIXEL", "J", array=pixels),
        fits.Column("SIGNAL", "E", array=(pixels * 0.5).astype(np.float32)),
        fits.Column("N_OBS", "J", array=pixels + 1),
    ]
)
keywords(explicit, "NESTED", INDXSCHM="EXPLICIT", OBJECT="PARTIAL")
write("explicit.fits", explicit)
print("explicit: pixels", pixels.sum(), "first absent", min(set(range(N)) - set(pixels.tolist())))

# Pixels 20 to 99 only, in order.
part = fits.BinTableHDU.from_columns([fits.Column("SIGNAL", "D", array=np.arange(20.0, 100.0))])
keywords(part, INDXSCHM="IMPLICIT", FIRSTPIX=20, LASTPIX=99)
write("implicit_part.fits", part)

# healpy's own gzipped file, of an nside that is no power of two.
hp.write_map(folder / "odd.fits.gz", np.arange(12.0 * 9), dtype=np.float64, overwrite=True)

# Maps as images: two of scaled integers with a null in the primary HDU, then one in three axes, a part of one, and
# one that is compressed.
null = -32768
scaled = np.stack([np.arange(N), 7 * np.arange(N)[::-1]]).astype(np.int16)
scaled[0, 11] = null
primary = fits.PrimaryHDU(scaled)
keywords(primary, COORDSYS="G", BSCALE=0.5, BZERO=-3.0, BLANK=null)
nested = fits.ImageHDU(np.arange(N, dtype=np.float32).reshape(12, NSIDE, NSIDE) ** 2, name="SQUARES")
keywords(nested, "NESTED")
upper = fits.ImageHDU(np.arange(5, 61, dtype=np.float64), name="UPPER")
keywords(upper, FIRSTPIX=5, LASTPIX=60)
bytes_ = fits.ImageHDU((np.arange(N) % 251).astype(np.uint8), name="BYTES")
keywords(bytes_)
packed = fits.CompImageHDU(np.arange(N, dtype=np.int32).reshape(12, 16), name="PACKED")
keywords(packed)
fits.HDUList([primary, nested, upper, bytes_, packed]).writeto(
    folder / "images.fits", overwrite=True, output_verify="silentfix"
)
with fits.open(folder / "images.fits") as file:
    print("images: second map of HDU 0, first values", file[0].data[1][:3], "NaN", np.isnan(file[0].data).sum())

# Columns whose names are numbers.
digits = fits.BinTableHDU.from_columns(
    [fits.Column(name, "D", array=np.full(N, value)) for name, value in [("1", 5.0), ("3X", 6.0), ("0", 7.0)]]
)
keywords(digits)
write("digits.fits", digits)

# Coefficients of 3 Y_00 + 0.5 y_2,1 + 2 y_3,-2 - y_4,0 in real harmonics y; the first table is 0.
alm = np.zeros(hp.Alm.getsize(4), complex)
for (l, m), a in {(0, 0): 3, (2, 1): 0.5 / np.sqrt(2), (3, 2): -2j / np.sqrt(2), (4, 0): -1}.items():
    alm[hp.Alm.getidx(4, l, m)] = a
np.save(folder / "alm.npy", alm)
hp.write_alm(folder / "alm.fits", [0 * alm, alm], overwrite=True)
