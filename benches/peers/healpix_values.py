"""Writes crates/healpix/tests/data/healpy.csv: values of healpy that the tests of sphvar-healpix compare with.

Usage: python3 benches/peers/healpix_values.py

healpy is installed with pip into a virtual environment in the user's cache folder, once.

Each row is `operation,order,nside,inputs,outputs`; inputs and outputs are numbers separated by spaces, floating-point ones
with 17 significant digits. Operations: pix2vec, pix2ang, vec2pix, ang2pix, ring2nest, nest2ring, neighbours (SW, W, NW,
N, NE, E, SE, S; -1 for none) and corners (N, W, S, E, each x y z).
"""

import math
import os
import random
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
OUTPUT = ROOT / "crates" / "healpix" / "tests" / "data" / "healpy.csv"
HEALPY = "1.20.1"
NSIDES = [1, 2, 3, 4, 5, 7, 18, 64, 1000, 2**20, 2**29]
SEED = 20240917


def enter_environment():
    """Runs this script again under an interpreter that has healpy."""
    try:
        import healpy  # noqa: F401

        return
    except ImportError:
        pass
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    folder = cache / f"sphvar-healpy-{HEALPY}"
    python = folder / "bin" / "python"
    if Path(sys.prefix) == folder:
        sys.exit(f"healpy is missing from {folder}; remove that folder and run again")
    if not python.exists():
        venv.create(folder, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", f"healpy=={HEALPY}"], check=True)
    os.execv(python, [str(python), *sys.argv])


def main():
    import healpy as hp
    import numpy as np

    rng = random.Random(SEED)
    rows = []

    def number(value):
        return str(int(value)) if isinstance(value, (int, np.integer)) else f"{float(value):.17g}"

    def row(operation, order, nside, inputs, outputs):
        fields = [" ".join(number(v) for v in group) for group in (inputs, outputs)]
        rows.append(f"{operation},{order},{nside},{fields[0]},{fields[1]}")

    def is_power(nside):
        return nside & (nside - 1) == 0

    def direction():
        z = rng.uniform(-1.0, 1.0)
        phi = rng.uniform(0.0, 2.0 * math.pi)
        radius = math.sqrt((1.0 - z) * (1.0 + z))
        return radius * math.cos(phi), radius * math.sin(phi), z

    for nside in NSIDES:
        n_pixels = 12 * nside * nside
        cap = 2 * nside * (nside - 1)
        # Ends of the numbering, the borders of the caps on both sides, the equatorial ring at longitude 0.
        special = {0, 3, n_pixels - 1, n_pixels - 4, cap - 1, cap, n_pixels - cap - 1, n_pixels - cap}
        special |= {cap + 4 * nside * nside, cap + 4 * nside * nside - 1}
        special |= {face * nside * nside for face in (0, 4, 8)} | {nside * nside - 1}
        pixels = sorted(p for p in special if 0 <= p < n_pixels)[:12]
        pixels += [rng.randrange(n_pixels) for _ in range(3)]

        for order in ["ring", "nest"] if is_power(nside) else ["ring"]:
            nest = order == "nest"
            for pixel in pixels:
                row("pix2vec", order, nside, [pixel], hp.pix2vec(nside, pixel, nest=nest))
            for pixel in pixels[::4]:
                row("pix2ang", order, nside, [pixel], hp.pix2ang(nside, pixel, nest=nest))
            for pixel in pixels[::3] + pixels[-2:]:
                row("neighbours", order, nside, [pixel], hp.get_all_neighbours(nside, pixel, nest=nest))
            for pixel in pixels[::5]:
                corners = hp.boundaries(nside, pixel, step=1, nest=nest)
                row("corners", order, nside, [pixel], corners.T.reshape(-1))

            poles_and_axes = [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)]
            # So close to the poles that 1 - |z| is zero.
            tiny = [(1e-9, 2e-9, 1.0), (-3e-10, 1e-12, -1.0)]
            vectors = [tuple(map(float, v)) for v in poles_and_axes] + tiny + [direction() for _ in range(4)]
            for vector in vectors:
                row("vec2pix", order, nside, vector, [hp.vec2pix(nside, *vector, nest=nest)])
            angles = [
                (0.0, 0.0),
                (math.pi, 0.0),
                (1e-9, 3.0),
                (0.3, 2.0 * math.pi - 1e-12),
                (0.3, -0.7),
                (1.1, 12.25),
                (math.acos(rng.uniform(-1.0, 1.0)), rng.uniform(0.0, 2.0 * math.pi)),
            ]
            for theta, phi in angles:
                row("ang2pix", order, nside, [theta, phi], [hp.ang2pix(nside, theta, phi, nest=nest)])

        if is_power(nside):
            for pixel in pixels[::2]:
                row("ring2nest", "ring", nside, [pixel], [hp.ring2nest(nside, pixel)])
                row("nest2ring", "nest", nside, [pixel], [hp.nest2ring(nside, pixel)])

    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    header = f"# healpy {hp.__version__}, written by benches/peers/healpix_values.py, seed {SEED}"
    OUTPUT.write_text("\n".join([header, "operation,order,nside,inputs,outputs", *rows]) + "\n")
    print(f"{len(rows)} rows -> {OUTPUT}")


if __name__ == "__main__":
    enter_environment()
    main()
