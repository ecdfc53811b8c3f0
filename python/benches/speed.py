"""Print the overhead of calls and the rates of samplers and HEALPix functions.

Run it with the wheel installed: builds for development are slower. Other programs disturb it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import sphvar
from sphvar import Sampler, healpix


def seconds(call: Callable[[], Any], tries: int = 7) -> float:
    """Return the shortest time of a call."""
    best = float("inf")
    for _ in range(tries):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    return best


def overhead(call: Callable[[], Any], repeats: int = 1000) -> float:
    """Return the time of a short call in microseconds."""

    def many() -> None:
        for _ in range(repeats):
            call()

    return 1e6 * seconds(many) / repeats


def main() -> None:
    """Print the figures."""
    one = Sampler("white-noise", 1)
    print("Overhead of a call, microseconds")
    for name, call in {
        "Sampler.random(1), one point": lambda: one.random(1),
        "Sampler(...)": lambda: Sampler("white-noise", 1),
        "healpix.vec2pix, one vector": lambda: healpix.vec2pix(64, 1.0, 0.0, 0.0),
        "healpix.pix2ang, one pixel": lambda: healpix.pix2ang(64, 17),
        "healpix.vec2pix, arrays of 1": lambda: healpix.vec2pix(64, *np.eye(3)[:, :1]),
    }.items():
        print(f"  {name:32}{overhead(call):8.2f}")

    n = 1_000_000
    print(f"\nSets of {n} points, nanoseconds per point, one thread")
    sphvar.set_num_threads(1)
    for spec in ["white-noise", "fibonacci", "jittered", "spiral"]:
        sampler = Sampler(spec, n, nearest=True)
        print(f"  {spec:32}{1e9 * seconds(lambda: sampler.random(1)) / sampler.n:8.2f}")
    sampler = Sampler("white-noise", 1000)
    print(f"  {'white-noise, 1000 sets of 1000':32}{1e9 * seconds(lambda: sampler.random(1000)) / n:8.2f}")

    print(f"\nHEALPix, {n} elements at nside 1024, nanoseconds per element, one thread")
    vectors = np.random.default_rng(0).normal(size=(3, n))
    pixels = healpix.vec2pix(1024, *vectors)
    theta, phi = healpix.pix2ang(1024, pixels)
    calls: dict[str, Callable[[Any], Any]] = {
        "vec2pix": lambda module: module.vec2pix(1024, *vectors),
        "ang2pix": lambda module: module.ang2pix(1024, theta, phi),
        "pix2vec": lambda module: module.pix2vec(1024, pixels),
        "pix2ang": lambda module: module.pix2ang(1024, pixels),
        "ring2nest": lambda module: module.ring2nest(1024, pixels),
        "nest2ring": lambda module: module.nest2ring(1024, pixels),
    }
    try:
        import healpy
    except ImportError:
        healpy = None
    for name, of in calls.items():
        line = f"  {name:32}{1e9 * seconds(lambda: of(healpix)) / n:8.2f}"
        if healpy is not None:
            line += f"   healpy{1e9 * seconds(lambda: of(healpy), 3) / n:8.2f}"
        print(line)
    sphvar.set_num_threads(0)

    samplers = [Sampler("step", 1024, seed=seed) for seed in range(2)]

    def together() -> None:
        threads = [threading.Thread(target=lambda s=s: s.random(1)) for s in samplers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    alone = seconds(lambda: samplers[0].reset().random(1), 3)
    print(f"\nTwo Python threads take {seconds(together, 3) / alone:.2f} times as long as one")

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sets.npy"
        words = ["sample", "white-noise", "-n", str(n), "-m", "20", "-j", "1", "--quiet", "-o"]
        run = [sys.executable, "-m", "sphvar._command", *words, str(path)]
        print(f"\nThe command with its file, 20 sets: {seconds(lambda: subprocess.run(run, check=True), 2):.2f} s")


if __name__ == "__main__":
    main()
