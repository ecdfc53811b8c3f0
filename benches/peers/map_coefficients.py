"""Compares the coefficients of HEALPix maps, and the time they take, with those of `map2alm` of healpy.

Usage: python3 benches/peers/map_coefficients.py [--quick] [--only REGEX] [--rounds N] [--server PROGRAM] [--venv FOLDER]

Both are given the same values in memory, in ring order, and the same number of threads: healpy runs `map2alm(iter=3)`,
its default, and sphvar `HealpixMap::alm` through crates/integrands/examples/map_server.rs. They take turns; the median of the
second of two consecutive calls counts. Maps have energies that fall as 1/l^2 up to degree min(3 nside - 1, 1000), noise
per pixel, and the mean 1.

The reference is the function that is constant on every pixel. Its coefficients do not change if every pixel is
divided into four, while all the quadratures do: the error of sphvar is the difference from the map of twice the nside,
up to nside 512. That of healpy is the difference from sphvar, which is the pixel window and aliasing. Both are norms of
differences over all orders, relative to the norm of the reference.

Exit status: 0 whatever the times; 1 if something cannot be built or the error of sphvar exceeds 1e-13.
"""

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from environment import Driver, default_environment, describe_machine, enter_environment, in_turn, stopwatch

PACKAGES = ["healpy", "numpy"]
# The default degree for lattices of 1000 points is 1265.
CASES = [(nside, lmax) for nside in (256, 512, 1024, 2048) for lmax in (128, 1265)]
MAX_ERROR = 1e-13
MAX_REFERENCE_NSIDE = 512


class Program(Driver):
    """The driver with a given program."""

    def __init__(self, program):
        self.name = str(program)
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def norm(alm, lmax):
    import numpy as np

    # Orders from 1 on also stand for negative ones.
    squares = np.abs(alm) ** 2
    return np.sqrt(squares[: lmax + 1].sum() + 2 * squares[lmax + 1 :].sum())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="nside 256 only")
    parser.add_argument("--only", type=re.compile, default=re.compile(""), metavar="REGEX", help="cases nside/lmax/threads")
    parser.add_argument("--rounds", type=int, default=5, metavar="N")
    parser.add_argument("--server", type=Path, metavar="PROGRAM", help="a built map_server instead of a release build")
    parser.add_argument("--venv", type=Path, metavar="FOLDER", help="the virtual environment, made if there is none")
    arguments = parser.parse_args()
    enter_environment(arguments.venv or default_environment(), PACKAGES)
    if "OMP_NUM_THREADS" not in os.environ:
        # healpy reads it when it is loaded, so that each number of threads needs a process.
        for threads in (1, 2):
            code = subprocess.run([sys.executable, *sys.argv], env={**os.environ, "OMP_NUM_THREADS": str(threads)}).returncode
            if code != 0:
                sys.exit(code)
        return
    compare(arguments, int(os.environ["OMP_NUM_THREADS"]))


def compare(arguments, threads):
    import healpy as hp
    import numpy as np

    server = Program(arguments.server) if arguments.server else Driver("map_server", "sphvar-integrands")
    server.ask("threads", threads)
    print(f"{threads} threads, {describe_machine()}, healpy {hp.__version__}")
    print("| nside | lmax | healpy s | sphvar s | ratio | error of healpy | error of sphvar |")
    print("|---|---|---|---|---|---|---|")
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "values"

        def coefficients(values, nside, lmax):
            values.astype("<f8").tofile(path)
            server.ask("load", path, nside)
            server.ask("run", lmax)
            server.ask("write", path)
            return np.fromfile(path, dtype="<c16")

        for nside, lmax in CASES:
            case = f"{nside}/{lmax}/{threads}"
            if arguments.quick and nside > 256 or not arguments.only.search(case):
                continue
            values = example(nside)
            error, reference = float("nan"), None
            if nside <= MAX_REFERENCE_NSIDE:
                reference = coefficients(hp.ud_grade(values, 2 * nside), 2 * nside, lmax)
            ours = coefficients(values, nside, lmax)
            if reference is not None:
                error = norm(ours - reference, lmax) / norm(reference, lmax)
                failed |= not error <= MAX_ERROR
            theirs = hp.map2alm(values, lmax=lmax, iter=3)
            difference = norm(theirs - ours, lmax) / norm(ours, lmax)
            healpy_times, times = [], []
            in_turn(
                arguments.rounds,
                [
                    (healpy_times, lambda: stopwatch(lambda: hp.map2alm(values, lmax=lmax, iter=3))),
                    (times, lambda: server.ask("run", lmax)),
                ],
            )
            theirs, ours = statistics.median(healpy_times), statistics.median(times)
            row = [nside, lmax, f"{theirs:.3g}", f"{ours:.3g}", f"{ours / theirs:.2f}", f"{difference:.1e}", f"{error:.1e}"]
            print("|", " | ".join(map(str, row)), "|", flush=True)
    server.close()
    if failed:
        sys.exit(f"the error of sphvar exceeds {MAX_ERROR}")


def example(nside):
    import healpy as hp
    import numpy as np

    lmax = min(3 * nside - 1, 1000)
    np.random.seed(nside)
    values = hp.synfast(1.0 / np.arange(1, lmax + 2) ** 2.0, nside, lmax=lmax)
    return values + 1.0 + 0.1 * np.random.standard_normal(values.size)


main()
