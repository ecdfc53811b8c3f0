"""Compares the time of a least-squares fit with that of pyshtools' SHExpandLSQ on the same values.

Usage: python3 benches/peers/fits.py SPHVAR [N] [LMAX]

SPHVAR is the command; N (default 20000) points of white noise have the values of a random function of degree LMAX (default
60) with noise. Needs numpy and pyshtools. Times are CPU seconds of one fit; that of sphvar includes reading the file
and the errors of energies, which SHExpandLSQ does not compute. Residuals of both are printed.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from itertools import zip_longest
from pathlib import Path

import numpy as np
import pyshtools


def children_cpu():
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def main():
    command = sys.argv[1]
    n, lmax = (int(given or default) for given, default in zip_longest(sys.argv[2:], (20_000, 60)))
    rng = np.random.default_rng(1)
    points = rng.normal(size=(n, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    lat, lon = np.degrees(np.arcsin(points[:, 2])), np.degrees(np.arctan2(points[:, 1], points[:, 0]))
    power = (1.0 + np.arange(lmax + 1)) ** -2.0
    function = pyshtools.SHCoeffs.from_random(power, seed=2)
    values = function.expand(lat=lat, lon=lon) + 0.1 * rng.normal(size=n)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "values.npy"
        np.save(path, np.column_stack([points, values]))
        start = children_cpu()
        fit = subprocess.run([command, "fit", path, "--lmax", str(lmax), "--json", "--quiet"], capture_output=True, check=True)
        ours = children_cpu() - start
    document = json.loads(fit.stdout)
    print(f"sphvar       {ours:8.2f} s CPU, rms of residuals {document['residual_rms']:.12g}", flush=True)
    start = time.process_time()
    _, chi2 = pyshtools.expand.SHExpandLSQ(values, lat, lon, lmax)
    theirs = time.process_time() - start
    print(f"SHExpandLSQ  {theirs:8.2f} s CPU, rms of residuals {np.sqrt(chi2 / n):.12g}")
    print(f"ratio        {theirs / ours:8.1f}")


if __name__ == "__main__":
    main()
