#!/usr/bin/env python3
"""Draws eight patterns and their spectra for the documentation of sphvar-samplers.

    pattern_pictures.py [--binary PATH] [-o PATH]

Every pattern has 192 points. The upper row shows the near half of a set, the lower one the mean power per degree.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import tempfile

N = 192
LMAX = 42
# The largest power that is drawn; lattices have higher peaks.
MAX_POWER = 3.0
PATTERNS = ["white-noise", "jittered", "poisson-disk", "ccvt", "healpix", "fibonacci", "step", "blue"]
COLUMN, RADIUS, WIDTH, HEIGHT = 120, 52, 104, 60
TOP_OF_SPECTRA = 140


def run(binary, *arguments):
    command = [binary, *arguments, "--quiet"]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def near_points(binary, pattern, folder):
    """The points with y < 0, seen along y with z upwards."""
    path = pathlib.Path(folder, f"{pattern}.csv")
    run(binary, "sample", pattern, "-n", str(N), "-o", str(path))
    with path.open() as lines:
        rows = csv.DictReader(line for line in lines if not line.startswith("#"))
        points = [[float(row[axis]) for axis in "xyz"] for row in rows]
    assert len(points) == N
    return [(x, z) for x, y, z in points if y < 0]


def power(binary, pattern):
    """The mean power of degrees from 1."""
    document = json.loads(run(binary, "spectrum", pattern, "-n", str(N), "--lmax", str(LMAX), "--json"))
    return document["power"][1:]


def column(binary, pattern, index, folder):
    left, middle = index * COLUMN, index * COLUMN + COLUMN / 2
    dots = "".join(
        f"M{middle + RADIUS * x:.1f} {RADIUS + 4 - RADIUS * z:.1f}h0" for x, z in near_points(binary, pattern, folder)
    )
    start, bottom = left + (COLUMN - WIDTH) / 2, TOP_OF_SPECTRA + HEIGHT
    height = lambda p: bottom - HEIGHT * min(p, MAX_POWER) / MAX_POWER
    curve = " ".join(f"{start + WIDTH * l / LMAX:.1f} {height(p):.1f}" for l, p in enumerate(power(binary, pattern), 1))
    return f"""<circle cx="{middle}" cy="{RADIUS + 4}" r="{RADIUS}" fill="none" stroke="currentColor" stroke-opacity="0.3"/>
<path d="{dots}" fill="none" stroke="currentColor" stroke-width="3.5" stroke-linecap="round"/>
<text x="{middle}" y="{TOP_OF_SPECTRA - 14}" text-anchor="middle" fill="currentColor">{pattern}</text>
<path d="M{start} {TOP_OF_SPECTRA}v{HEIGHT}h{WIDTH}" fill="none" stroke="currentColor" stroke-opacity="0.5"/>
<path d="M{start} {height(1):.1f}h{WIDTH}" stroke="currentColor" stroke-opacity="0.3" stroke-dasharray="3 3"/>
<path d="M{curve}" fill="none" stroke="#3a7bd5" stroke-width="1.5" stroke-linejoin="round"/>
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", default="target/release/sphvar")
    parser.add_argument("-o", "--out", type=pathlib.Path, default=pathlib.Path("crates/samplers/images/patterns.svg"))
    arguments = parser.parse_args()
    width, height = COLUMN * len(PATTERNS), TOP_OF_SPECTRA + HEIGHT + 4
    with tempfile.TemporaryDirectory() as folder:
        columns = [column(arguments.binary, pattern, i, folder) for i, pattern in enumerate(PATTERNS)]
    # Rustdoc includes the text as it is: an empty line would end the picture.
    arguments.out.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="100%" font-family="sans-serif" '
        f'font-size="13" role="img" aria-label="Eight patterns of {N} points and their power per degree">\n'
        + "".join(columns)
        + "</svg>\n"
    )


if __name__ == "__main__":
    main()
