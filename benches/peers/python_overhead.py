"""Measures what the package for Python adds to the time of transforms in the library.

Usage: python benches/peers/python_overhead.py [--quick] [--json FILE]

Run it with the interpreter of an environment in which the package is installed (`pip install ./python`, a release build).

  calls       The median time of calls with the smallest inputs. Most of it is that of reading arguments and of making
              the result, so it is the overhead of a call: at most 20 microseconds. `python/benches/speed.py` has those of
              samplers and of HEALPix functions.
  transforms  points2alm and alm2points of 1e6 points to degree 1024, beside the same transforms of the library, which the
              example `whole_transforms` of the package sphvar-sht runs: it makes the plan, transforms and drops
              everything, as one call from Python does. Runs alternate; the ratio is that of the medians, which should
              be at most 1.03.

Prints the machine first. Exit status: 0, or 1 if a limit is exceeded or the example cannot be built.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import sphvar

ROOT = Path(__file__).resolve().parents[2]
MAX_OVERHEAD = 20e-6
MAX_RATIO = 1.03
N_POINTS, LMAX = 1_000_000, 1024


def machine():
    """The processor, the number of cores that this process may use, and the versions."""
    name = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        name = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), name)
    except OSError:
        pass
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{name}, {cores} cores; sphvar {sphvar.__version__}, Python {platform.python_version()}, numpy {np.__version__}"


def seconds_of_call(call, rounds, calls=200):
    """The median over rounds of the mean time of a call."""
    times = []
    call()
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(calls):
            call()
        times.append((time.perf_counter() - start) / calls)
    return statistics.median(times)


def small_calls():
    """Transforms of one point to degree 0."""
    point = np.array([[0.0, 0.0, 1.0]])
    alm = np.array([1.0 + 0j])
    return {
        "points2alm(1 point, 0)": lambda: sphvar.points2alm(point, 0),
        "alm2points(1 coefficient, 1 point)": lambda: sphvar.alm2points(alm, point),
    }


def library_times(rounds):
    """A generator of the times of the library: of the adjoint, then of the synthesis, in turn."""
    command = ["cargo", "build", "--release", "-p", "sphvar-sht", "--example", "whole_transforms"]
    subprocess.run(command, cwd=ROOT, check=True)
    metadata = subprocess.run(
        ["cargo", "metadata", "--format-version", "1", "--no-deps"], cwd=ROOT, check=True, capture_output=True
    )
    example = Path(json.loads(metadata.stdout)["target_directory"]) / "release" / "examples" / "whole_transforms"
    process = subprocess.Popen(
        [example, str(N_POINTS), str(LMAX)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    for _ in range(2 * rounds + 2):
        process.stdin.write("\n")
        process.stdin.flush()
        yield float(process.stdout.readline())
    process.stdin.close()
    process.wait()


def transform_ratios(rounds):
    """The median times of Python and of the library for both transforms."""
    points = np.random.default_rng(0).normal(size=(N_POINTS, 3))
    points /= np.linalg.norm(points, axis=1)[:, np.newaxis]
    alm = sphvar.points2alm(points, LMAX)
    calls = [lambda: sphvar.points2alm(points, LMAX), lambda: sphvar.alm2points(alm, points)]
    library = library_times(rounds)
    times = {"points2alm": ([], []), "alm2points": ([], [])}
    # The first round fills caches and is not counted.
    for turn in range(rounds + 1):
        for call, (ours, theirs) in zip(calls, times.values()):
            start = time.perf_counter()
            call()
            taken = time.perf_counter() - start
            of_library = next(library)
            if turn > 0:
                ours.append(taken)
                theirs.append(of_library)
    return {name: tuple(map(statistics.median, pair)) for name, pair in times.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="few rounds")
    parser.add_argument("--json", type=Path, help="write the numbers to a file")
    args = parser.parse_args()
    print(machine())
    failed = False
    print("\nmicroseconds of a call with the smallest input")
    overheads = {}
    for name, call in small_calls().items():
        overheads[name] = seconds_of_call(call, 5 if args.quick else 41)
        failed |= overheads[name] > MAX_OVERHEAD
        print(f"{1e6 * overheads[name]:8.2f}  {name}", flush=True)
    print(f"\nmilliseconds of {N_POINTS} points to degree {LMAX}: Python, library, ratio")
    transforms = transform_ratios(3 if args.quick else 15)
    for name, (ours, library) in transforms.items():
        failed |= ours / library > MAX_RATIO
        print(f"{1e3 * ours:8.1f} {1e3 * library:8.1f} {ours / library:8.3f}  {name}")
    if args.json:
        numbers = {"machine": machine(), "overheads": overheads, "transforms": transforms}
        args.json.write_text(json.dumps(numbers, indent=1) + "\n")
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
