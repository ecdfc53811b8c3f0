"""Compares the time of transforms of scattered points on the torus with that of FINUFFT.

Usage: python3 benches/peers/torus.py [--quick] [--only REGEX] [--json FILE] [--venv FOLDER]

Contestants: finufft.Plan in f64 and, for targets that it can reach, in f32 (one thread, plan made before, its own choice of
oversampling and sorting); sphvar through crates/nufft/examples/torus_server.rs (one thread, plan and memory made before).
Each call sets the points and transforms: points change from call to call in the use that is timed. FINUFFT has complex weights
and coefficients only; for real ones it is given the same numbers.

Each case is run by two rules, both at a measured error of sphvar that is no larger than that of its rivals.
  finufft leads  FINUFFT runs with the target as its tolerance. Its variants whose measured error meets ten times the target are the
                 rivals; sphvar runs with the largest epsilon of a ladder at which its measured error is at most that of every rival.
  sphvar leads   sphvar runs with the target as its epsilon. Each variant of FINUFFT runs with the smallest tolerance of a
                 ladder from the target upwards at which its measured error is at least that of sphvar.
Median times are compared with the fastest rival. The contestants alternate. Times are CPU seconds of the process, several calls
together, so that other work on the machine has little influence.

The error is ||x - x_ref|| / ||x_ref|| over 200 random frequencies (type 1) or points (type 2), half of the frequencies with
|k1| and |k2| above 0.9 kmax; x_ref is the direct sum, with angles in extended precision.

Exit status: 0 whether or not sphvar is as fast as required; 1 if something cannot be built or an error of sphvar exceeds ten times
the target.
"""

import argparse
import json
import re
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from environment import Driver, default_environment, describe_machine, enter_environment

PACKAGES = ["finufft==2.5.*", "numpy"]
SEED = 20240917
SAMPLES = 200
# The epsilons of sphvar divided by the target.
LADDER = [10, 5, 3, 2, 1, 0.7, 0.5, 0.35, 0.25, 0.17, 0.1, 0.05, 0.025, 0.01]
# The tolerances of FINUFFT divided by the target, where sphvar leads.
LOOSER = [1, 1.5, 2.5, 4, 7, 12, 20, 35, 60, 100]
FINEST_SPHVAR = 1e-13
# FINUFFT in f32 does not reach smaller errors.
SINGLE_LIMIT = 1e-6
REQUIRED_RATIO = 1.3
# Calls that are timed together take this long.
SECONDS_TOGETHER = 0.1
TYPES = ["1", "1-complex", "2", "2-complex"]


@dataclass
class Case:
    kind: str
    n_points: int
    kmax: int
    target: float
    leader: str

    @property
    def name(self):
        return f"type {self.kind} {self.n_points}/{2 * self.kmax + 1}^2/{self.target:.0e} {self.leader}"


SIZES = [(1000, 64, 15), (4096, 128, 15), (10_000, 200, 11), (100_000, 256, 7), (1_000_000, 512, 5)]
TARGETS = [1e-5, 1e-9, 1e-12]


@dataclass
class Contestant:
    label: str
    requested: float
    error: float
    samples: list = field(default_factory=list)

    @property
    def median(self):
        return statistics.median(self.samples)


class Problem:
    """Points and numbers of a case, their reference, and both codes on them."""

    def __init__(self, case, server, folder):
        import numpy as np

        rng = np.random.default_rng(SEED)
        self.case, self.server, self.folder = case, server, folder
        n, kmax = case.n_points, case.kmax
        self.points = rng.random((n, 2))
        self.is_type_1, self.is_real = case.kind.startswith("1"), "complex" not in case.kind
        self.angles = [np.ascontiguousarray(2.0 * np.pi * self.points[:, i]) for i in range(2)]
        modes = 2 * kmax + 1
        if self.is_type_1:
            numbers = rng.standard_normal(n) + (0.0 if self.is_real else 1j * rng.standard_normal(n))
            ours = numbers
            self.numbers = numbers.astype(complex)
            line = rng.integers(-kmax, kmax + 1, (SAMPLES, 2))
            high = rng.integers(int(0.9 * kmax), kmax + 1, (SAMPLES // 2, 2)) * rng.choice([-1, 1], (SAMPLES // 2, 2))
            line[: SAMPLES // 2] = high
            # sphvar stores half of the coefficients of real weights.
            line[line[:, 1] < 0] *= -1 if self.is_real else 1
            self.frequencies = line
            self.reference = self.direct(self.points, self.numbers, line, -1)
        else:
            numbers = rng.standard_normal((modes, modes)) + 1j * rng.standard_normal((modes, modes))
            if self.is_real:
                numbers = numbers + numbers[::-1, ::-1].conj()
            ours = np.ascontiguousarray(numbers[:, kmax:] if self.is_real else numbers)
            self.numbers = numbers
            self.chosen = rng.choice(n, SAMPLES, replace=False)
            k = np.arange(-kmax, kmax + 1)
            lines = self.waves(self.points[self.chosen, 0], k), self.waves(self.points[self.chosen, 1], k)
            self.reference = np.einsum("ja,ab,jb->j", lines[0], numbers, lines[1], optimize=True)
        points_file, numbers_file = folder / "points", folder / "numbers"
        self.points.tofile(points_file)
        ours.tofile(numbers_file)
        server.ask("points", points_file)
        server.ask("numbers", numbers_file)

    @staticmethod
    def waves(x, k):
        """exp(2 pi i k x) for each coordinate (row) and frequency (column)."""
        import numpy as np

        turns = np.outer(x.astype(np.longdouble), k)
        turns -= np.rint(turns)
        return np.exp(2j * np.pi * turns.astype(float))

    @staticmethod
    def direct(points, weights, frequencies, sign):
        import numpy as np

        sums = []
        for k in frequencies:
            turns = points.astype(np.longdouble) @ k.astype(np.longdouble)
            turns -= np.rint(turns)
            sums.append((weights * np.exp(sign * 2j * np.pi * turns.astype(float))).sum())
        return np.array(sums)

    def error(self, results):
        import numpy as np

        return float(np.linalg.norm(results - self.reference) / np.linalg.norm(self.reference))

    def finufft(self, dtype, tolerance):
        """A function that sets points and transforms, and its error."""
        import finufft
        import numpy as np

        modes = 2 * self.case.kmax + 1
        sign = -1 if self.is_type_1 else 1
        plan = finufft.Plan(1 if self.is_type_1 else 2, (modes, modes), eps=tolerance, isign=sign, dtype=dtype, nthreads=1)
        real = np.float32 if dtype == "complex64" else np.float64
        x, y = (a.astype(real) for a in self.angles)
        numbers = np.ascontiguousarray(self.numbers.astype(dtype))
        out = np.empty((modes, modes) if self.is_type_1 else len(x), dtype=dtype)

        def transform():
            plan.setpts(x, y)
            plan.execute(numbers, out=out)

        transform()
        found = out[tuple((self.frequencies + self.case.kmax).T)] if self.is_type_1 else out[self.chosen]
        return transform, self.error(found)

    def sphvar(self, epsilon):
        """The error of sphvar after planning."""
        import numpy as np

        kmax = self.case.kmax
        self.server.ask("plan", self.case.kind, kmax, epsilon)
        path = self.folder / "result"
        self.server.ask("write", path)
        if self.is_type_1:
            columns = kmax + 1 if self.is_real else 2 * kmax + 1
            values = np.fromfile(path, dtype=complex).reshape(-1, columns)
            k1, k2 = self.frequencies.T
            found = values[k1 + kmax, k2 + (0 if self.is_real else kmax)]
        else:
            found = np.fromfile(path, dtype=float if self.is_real else complex)[self.chosen]
        return self.error(found)

    def contestants(self):
        target = self.case.target
        dtypes = ["complex128", "complex64"] if target >= SINGLE_LIMIT else ["complex128"]
        if self.case.leader == "sphvar":
            ours = Contestant("sphvar", target, self.sphvar(target))
            rivals = [self.rival_at(d, ours.error) for d in dtypes]
        else:
            rivals = [(Contestant(d, target, error), f) for d in dtypes for f, error in [self.finufft(d, target)]]
            rivals = [r for r in rivals if r[0].error <= 10 * target]
            bound = min(c.error for c, _ in rivals)
            for factor in LADDER:
                requested = max(target * factor, FINEST_SPHVAR)
                ours = Contestant("sphvar", requested, self.sphvar(requested))
                if ours.error <= bound:
                    break
        return rivals, ours

    def rival_at(self, dtype, bound):
        for factor in LOOSER:
            transform, error = self.finufft(dtype, self.case.target * factor)
            if error >= bound:
                break
        return Contestant(dtype, self.case.target * factor, error), transform


def time_in_turn(case, rounds, server, rivals, ours):
    """Appends the CPU seconds of a call of each contestant, each round beginning with another."""
    cpu_clock = (~server.process.pid << 3) | 2

    def of_server(count):
        start = time.clock_gettime(cpu_clock)
        server.ask("run", count)
        return time.clock_gettime(cpu_clock) - start

    def of_function(transform):
        def timed(count):
            start = time.process_time()
            for _ in range(count):
                transform()
            return time.process_time() - start

        return timed

    contestants = [(ours, of_server), *((c, of_function(f)) for c, f in rivals)]
    counts = [max(1, round(SECONDS_TOGETHER / timed(1))) for _, timed in contestants]
    for r in range(rounds):
        for i in range(len(contestants)):
            k = (r + i) % len(contestants)
            contestant, timed = contestants[k]
            contestant.samples.append(timed(counts[k]) / counts[k])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="to 10000 points only")
    parser.add_argument("--only", default="", help="cases whose name matches")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--venv", type=Path, default=None)
    arguments = parser.parse_args()
    enter_environment(arguments.venv or default_environment(), PACKAGES)
    server = Driver("torus_server", package="sphvar-nufft")
    print(json.dumps(describe_machine()))
    print("| case | finufft f64 | finufft f32 | sphvar | errors | ratio |\n|---|---|---|---|---|---|")
    rows, accurate = [], True
    cases = [
        (Case(kind, n, kmax, target, leader), rounds)
        for kind in TYPES
        for n, kmax, rounds in SIZES
        for target in TARGETS
        for leader in ["finufft", "sphvar"]
        if not arguments.quick or n <= 10_000
    ]
    with tempfile.TemporaryDirectory() as folder:
        for case, rounds in cases:
            if not re.search(arguments.only, case.name):
                continue
            problem = Problem(case, server, Path(folder))
            rivals, ours = problem.contestants()
            time_in_turn(case, rounds, server, rivals, ours)
            by_type = {c.label: c for c, _ in rivals}
            columns = [by_type.get("complex128"), by_type.get("complex64"), ours]
            times = [f"{1e3 * c.median:.3g}" if c else "-" for c in columns]
            errors = [f"{c.error:.1e}" if c else "-" for c in columns]
            ratio = min(c.median for c, _ in rivals) / ours.median
            accurate &= ours.error <= 10 * case.target
            print(f"| {case.name} | {' | '.join(times)} | {', '.join(errors)} | {ratio:.2f} |", flush=True)
            rows.append({"case": case.name, "ratio": ratio, "contestants": [vars(c) for c in columns if c]})
    server.close()
    met = sum(row["ratio"] >= REQUIRED_RATIO for row in rows)
    print(f"{met} of {len(rows)} cases with a ratio of at least {REQUIRED_RATIO}")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1))
    sys.exit(0 if accurate else 1)


if __name__ == "__main__":
    main()
