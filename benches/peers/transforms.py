"""Compares the time of the fast adjoint transform of scattered points with that of ducc0.

Usage: python3 benches/peers/transforms.py [--quick] [--only REGEX] [--json FILE] [--venv FOLDER]

Contestants: ducc0.sht.adjoint_synthesis_general (spin 0, mmax = lmax, one thread, its own choice of oversampling, a
given array for its result, freed memory kept in the process) with a map of f64 and, for targets that it can reach, of
f32; sphvar through tests/examples/transform_server.rs (one thread, plan and memory made before). ducc0 is given
colatitudes and longitudes made before the clock starts, sphvar unit vectors: it finds the angles within its time.

Each case is run by two rules, both at a measured error of sphvar that is no larger than that of its rivals.
  ducc0 leads   ducc0 runs with the target as its epsilon. Its variants whose measured error meets the target are the rivals. sphvar
                runs with the largest epsilon of a ladder around the target at which its measured error is at most
                that of every rival.
  sphvar leads  sphvar runs with the target as its epsilon. Each variant of ducc0 runs with the smallest epsilon of a
                ladder from the target upwards at which its measured error is at least that of sphvar.
Median times are compared with the fastest rival. The contestants alternate; of two consecutive calls the second counts.

The error is ||a - a_ref|| / ||a_ref|| over all orders of either sign, for the unit vectors as given; a_ref is one of
  exact        sphvar's exact transform, where that is affordable;
  ducc0        else, for targets far above 1e-13: ducc0 at its finest accuracy;
  exact of n   else: the exact transform of the first n points, while the codes are given all of them, the others with
               weight 0. Errors of this size come from the angles and the windows of single points.
How far the codes at their finest accuracy are from each other, and from an exact a_ref, is printed, so that the
reference does not rest on one of them.

An ensemble is many sets of points on two cores: two threads of sphvar, or two processes of ducc0 with one thread
each, start at the same moment and take the next four sets until none is left. The making of sphvar's plan and threads
counts, the start of ducc0's processes and the making of points do not.

Exit status: 0 whether or not sphvar is as fast as required; 1 if something cannot be built or an error exceeds the
requested accuracy.
"""

import argparse
import json
import math
import multiprocessing
import re
import statistics
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from environment import Driver, default_environment, describe_machine, enter_environment, in_turn, stopwatch

PACKAGES = ["ducc0==0.42.*", "numpy"]
SEED = 20240917
# Below this N L^2 the exact transform takes a second or less. It is good to about 4e-17 times the degree.
EXACT_LIMIT = 2e9
# The smallest accuracies that the two codes accept or meet.
FINEST_DUCC = 3e-14
FINEST_SPHVAR = 1e-13
# The codes at their finest may differ by this: the smallest target.
AGREEMENT = 1e-12
# From this target up ducc0 at its finest accuracy suffices as a reference.
ROUGH_TARGET = 1e-9
# ducc0 rejects f32 below 1e-6.
SINGLE_LIMIT = 1e-5
# The epsilons of sphvar divided by the target: fine enough to find every width of its window.
LADDER = [4, 2, 1, 0.7, 0.5, 0.35, 0.25, 0.17, 0.1, 0.07, 0.05, 0.035, 0.025, 0.017, 0.01]
# The epsilons of ducc0 divided by the target, where sphvar leads.
LOOSER = [1, 1.5, 2.5, 4, 7, 12, 20, 35, 60, 100]
# Sets of an ensemble that errors are measured with, and that a worker takes at a time.
PROBES = 4
BATCH = 4
WORKERS = 2
# Seconds after which a worker counts as dead.
WORKER_PATIENCE = 120
# Enough for ducc0 to keep all it frees (GiB), as sphvar keeps its workspace.
KEPT_MEMORY = 8.0


@dataclass
class Case:
    n_points: int
    lmax: int
    target: float
    rounds: int
    # The required ratio of ducc0's time to sphvar's; None where nothing is required.
    required_ratio: float | None = None
    # More than one: an ensemble.
    sets: int = 1
    leader: str = "ducc0"

    @property
    def name(self):
        prefix = "ensemble " if self.sets > 1 else ""
        mantissa, exponent = f"{self.target:e}".split("e")
        return f"{prefix}{self.n_points}/{self.lmax}/{float(mantissa):g}e{int(exponent)} {self.leader}"


CASES = [
    Case(1024, 128, 1e-5, 41),
    Case(4096, 256, 1e-5, 41),
    Case(4096, 512, 1e-5, 31),
    Case(100_000, 1024, 1e-5, 15, 1.0),
    Case(1_000_000, 1024, 1e-5, 9, 1.0),
    Case(1_000_000, 1024, 1e-12, 9, 1.0),
    Case(1_000_000, 2048, 1e-5, 7, 1.0),
    Case(1_000_000, 2048, 1e-12, 7, 1.0),
    Case(4096, 256, 1e-5, 5, 2.0, sets=1000),
]
QUICK_POINTS = 100_000
QUICK_SETS = 200


@dataclass
class Contestant:
    """One column of the table: its requested and measured accuracy, and its seconds for one transform."""

    label: str
    requested: float
    error: float
    samples: list = field(default_factory=list)

    @property
    def median(self):
        return statistics.median(self.samples)


class Server(Driver):
    """The process that runs sphvar's transforms; see tests/examples/transform_server.rs."""

    def __init__(self):
        super().__init__("transform_server")

    def coefficients(self, folder):
        import numpy as np

        path = folder / "coefficients"
        self.ask("write", path)
        return np.fromfile(path, dtype="<c16")


def ducc_transform(case, dtype, n_weighed=None):
    """A function that transforms case.n_points places to an accuracy, always into the same array; of weight 1 are the
    first n_weighed, or all, of weight 0 the others."""
    import ducc0
    import numpy as np

    weights = np.zeros((1, case.n_points), dtype=dtype)
    weights[:, :n_weighed] = 1.0
    out = np.empty((1, (case.lmax + 1) * (case.lmax + 2) // 2), dtype=np.result_type(dtype, np.complex64))
    fixed = {"map": weights, "spin": 0, "lmax": case.lmax, "mmax": case.lmax, "nthreads": 1, "alm": out}

    def transform(angles, epsilon):
        return ducc0.sht.adjoint_synthesis_general(loc=angles, epsilon=epsilon, **fixed)[0]

    return transform


def make_points(n, rng):
    """Unit vectors of independent uniform directions, and the same as colatitudes and longitudes in [0, 2 pi)."""
    import numpy as np

    xyz = rng.standard_normal((n, 3))
    xyz /= np.linalg.norm(xyz, axis=1, keepdims=True)
    theta = np.arctan2(np.hypot(xyz[:, 0], xyz[:, 1]), xyz[:, 2])
    phi = np.arctan2(xyz[:, 1], xyz[:, 0])
    phi = np.where(phi < 0.0, phi + 2.0 * math.pi, phi)
    return xyz, np.stack([theta, phi], axis=1)


def distance(results, references, lmax):
    """The relative error of lists of coefficients; orders from 0 up are stored, m = 0 first, others count twice."""
    import numpy as np

    def squared_norm(alm):
        squares = alm.real.astype(np.float64) ** 2 + alm.imag.astype(np.float64) ** 2
        return 2.0 * squares.sum() - squares[: lmax + 1].sum()

    off = sum(squared_norm(a - b) for a, b in zip(results, references, strict=True))
    return math.sqrt(off / sum(squared_norm(b) for b in references))


class Probe:
    """The sets that errors are measured with: files for sphvar, angles for ducc0, and reference coefficients."""

    def __init__(self, case, sets, server, folder):
        self.case, self.server, self.folder = case, server, folder
        self.angles = [angles for _, angles in sets]
        self.paths = []
        for k, (xyz, _) in enumerate(sets):
            self.paths.append(folder / f"set{k}")
            xyz.tofile(self.paths[-1])

        self.n_weighed = None
        self.finest = self.ducc("float64", FINEST_DUCC)
        ours = self.sphvar("plan", case.lmax, FINEST_SPHVAR)
        self.spread = distance(ours, self.finest, case.lmax)
        self.distances = {"sphvar to ducc0": self.spread}
        if case.n_points * case.lmax**2 >= EXACT_LIMIT:
            if case.target >= ROUGH_TARGET:
                self.reference_name, self.reference = "ducc0", self.finest
                return
            self.n_weighed = int(EXACT_LIMIT / case.lmax**2)
        self.reference_name = "exact" + (f" of {self.n_weighed}" if self.n_weighed else "")
        self.reference = self.sphvar("exact", case.lmax)
        self.distances["ducc0 to exact"] = self.error(self.ducc("float64", FINEST_DUCC))
        self.distances["sphvar to exact"] = self.error(self.sphvar("plan", case.lmax, FINEST_SPHVAR))

    def ducc(self, dtype, epsilon):
        transform = ducc_transform(self.case, dtype, self.n_weighed)
        return [transform(angles, epsilon).copy() for angles in self.angles]

    def sphvar(self, *command):
        results = []
        for path in self.paths:
            self.server.ask("load", path, self.case.n_points)
            if self.n_weighed:
                self.server.ask("weigh", self.n_weighed)
            self.server.ask(*command)
            results.append(self.server.coefficients(self.folder))
        return results

    def error(self, results):
        return distance(results, self.reference, self.case.lmax)

    def rival_at(self, dtype, bound):
        """ducc0 at the smallest epsilon of its ladder that gives at least this error."""
        for factor in LOOSER:
            requested = self.case.target * factor
            contestant = Contestant(f"ducc0 {dtype}", requested, self.error(self.ducc(dtype, requested)))
            if contestant.error >= bound:
                break
        return contestant

    def contestants(self):
        """ducc0 in double and maybe single precision, and sphvar, with their requested accuracies by the rule."""
        target = self.case.target
        dtypes = ["float64", "float32"] if target >= SINGLE_LIMIT else ["float64"]
        if self.case.leader == "sphvar":
            ours = Contestant("sphvar", target, self.error(self.sphvar("plan", self.case.lmax, target)))
            return [self.rival_at(d, ours.error) for d in dtypes], ours
        duccs = [Contestant(f"ducc0 {d}", target, self.error(self.ducc(d, target))) for d in dtypes]
        bound = min(c.error for c in rivals(duccs, target))
        tried = []
        for factor in LADDER:
            requested = target * factor
            error = self.error(self.sphvar("plan", self.case.lmax, requested))
            tried.append(Contestant("sphvar", requested, error))
            if error <= bound:
                break
        return duccs, min(tried, key=lambda c: c.error)


def rivals(duccs, target):
    """The variants that meet the target, or else the most accurate."""
    return [c for c in duccs if c.error <= target] or [min(duccs, key=lambda c: c.error)]


def time_single(case, probe, server, duccs, ours):
    server.ask("load", probe.paths[0], case.n_points)
    server.ask("plan", case.lmax, ours.requested)
    contestants = [(ours.samples, lambda: server.ask("run"))]
    for c in duccs:
        transform = ducc_transform(case, c.label.split()[1])
        arguments = (transform, probe.angles[0], c.requested)
        stopwatch(*arguments)
        contestants.append((c.samples, lambda arguments=arguments: stopwatch(*arguments)))
    in_turn(case.rounds, contestants)
    return server.coefficients(probe.folder)


def ensemble_worker(path, case, next_set, barrier, orders, times):
    """Transforms its part of the sets with ducc0 for every (dtype, epsilon) ordered; None ends it."""
    import ducc0
    import numpy as np

    ducc0.misc.set_heap_trim_limit(KEPT_MEMORY)
    sets = np.load(path)
    while (order := orders.get()) is not None:
        dtype, epsilon = order
        transform = ducc_transform(case, dtype)
        transform(sets[0], epsilon)
        barrier.wait(WORKER_PATIENCE)
        start = time.perf_counter()
        while True:
            with next_set.get_lock():
                first = next_set.value
                next_set.value += BATCH
            if first >= len(sets):
                break
            for locations in sets[first : first + BATCH]:
                transform(locations, epsilon)
        # On Linux this clock is the same for all processes.
        times.put((start, time.perf_counter()))


def time_ensemble(case, probe, server, duccs, ours, sets):
    import numpy as np

    xyz_path, angles_path = probe.folder / "all", probe.folder / "angles.npy"
    np.concatenate([xyz for xyz, _ in sets]).tofile(xyz_path)
    np.save(angles_path, np.stack([angles for _, angles in sets]))

    context = multiprocessing.get_context("spawn")
    next_set, barrier, times = context.Value("q", 0), context.Barrier(WORKERS), context.Queue()
    orders = [context.Queue() for _ in range(WORKERS)]
    workers = [
        context.Process(target=ensemble_worker, args=(angles_path, case, next_set, barrier, o, times), daemon=True)
        for o in orders
    ]
    for worker in workers:
        worker.start()

    def ducc_ensemble(contestant):
        next_set.value = 0
        for queue in orders:
            queue.put((contestant.label.split()[1], contestant.requested))
        spans = [times.get(timeout=WORKER_PATIENCE) for _ in workers]
        return (max(end for _, end in spans) - min(start for start, _ in spans)) / case.sets

    def our_ensemble():
        words = [case.sets, case.n_points, case.lmax, ours.requested, WORKERS]
        return server.ask("ensemble", *words) / case.sets

    server.ask("load", xyz_path, case.sets * case.n_points)
    contestants = [(ours.samples, our_ensemble), *((c.samples, lambda c=c: ducc_ensemble(c)) for c in duccs)]
    in_turn(case.rounds, contestants)
    for queue in orders:
        queue.put(None)
    for worker in workers:
        worker.join()
    return server.coefficients(probe.folder)


@dataclass
class Row:
    case: Case
    duccs: list
    ours: Contestant
    reference: str
    distances: dict
    complaints: list

    @property
    def rivals(self):
        return self.duccs if self.case.leader == "sphvar" else rivals(self.duccs, self.case.target)

    @property
    def rival(self):
        return min(self.rivals, key=lambda c: c.median)

    @property
    def ratio(self):
        return self.rival.median / self.ours.median

    @property
    def accurate(self):
        return all(self.ours.error <= c.error for c in self.rivals)

    @property
    def verdict(self):
        if not self.accurate:
            return "missed: error"
        if self.case.required_ratio is None:
            return ""
        return "met" if self.ratio >= self.case.required_ratio else "missed"

    def line(self):
        cells = [f"{self.case.name:<31}"]
        for c in [*self.duccs, *[None] * (2 - len(self.duccs)), self.ours]:
            if c is None:
                cells.append(f"{'-':>9} {'-':>9} {'-':>7}")
            else:
                cells.append(f"{1e3 * c.median:9.3f} {1e3 * min(c.samples):9.3f} {c.error:7.1e}")
        required = "-" if self.case.required_ratio is None else f"{self.case.required_ratio:.1f}"
        cells.append(f"{self.ours.requested:7.1e} | {self.ratio:5.2f} {required:>8} {self.verdict}")
        return " | ".join(cells[:-1]) + " " + cells[-1]

    def as_json(self):
        measured = {"ratio": self.ratio, "rival": self.rival.label, "verdict": self.verdict}
        return {"name": self.case.name, **asdict(self), **measured}


HEADER = "\n".join(
    [
        f"{'':31} | {'ducc0, f64':^27} | {'ducc0, f32':^27} | {'sphvar':^35} | ducc0/sphvar",
        f"{'points/degree/target leader':<31} | "
        + 2 * f"{'median':>9} {'min':>9} {'error':>7} | "
        + f"{'median':>9} {'min':>9} {'error':>7} {'request':>7} | ratio required",
    ]
)


def measure(case, server):
    import numpy as np

    rng = np.random.default_rng([SEED, case.n_points, case.lmax])
    sets = [make_points(case.n_points, rng) for _ in range(case.sets)]
    with tempfile.TemporaryDirectory(prefix="sphvar-peers-") as name:
        probe = Probe(case, sets[:PROBES], server, Path(name))
        duccs, ours = probe.contestants()
        if case.sets > 1:
            last = time_ensemble(case, probe, server, duccs, ours, sets)
        else:
            last = time_single(case, probe, server, duccs, ours)
        complaints = []
        for codes, off in probe.distances.items():
            if not off <= AGREEMENT:
                complaints.append(f"at their finest accuracy, {codes} is {off:.1e}")
        # What was timed last is the first of the probes. The reference is no better than the spread.
        as_timed = distance([last], probe.finest[:1], case.lmax)
        for what, error in [("sphvar", ours.error), ("sphvar as timed", as_timed)]:
            if not error <= ours.requested + probe.spread:
                complaints.append(f"{what} requested {ours.requested:.1e}, but the error is {error:.1e}")
        return Row(case, duccs, ours, probe.reference_name, probe.distances, complaints)


def describe_environment():
    import ducc0
    import numpy as np

    info = getattr(ducc0.misc, "cpu_info", dict)()
    profile = f" ({info['active_profile']})" if "active_profile" in info else ""
    return describe_machine() | {"ducc0": ducc0.__version__ + profile, "numpy": np.__version__}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0], epilog="The docstring of the script has the details.")
    parser.add_argument("--quick", action="store_true", help="no case of a million points, an ensemble of fewer sets")
    only = "cases whose name matches: points/degree/target leader, after `ensemble ` if it is one"
    parser.add_argument("--only", type=re.compile, default="", metavar="REGEX", help=only)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write all samples")
    folder = "the virtual environment, made if there is none; default: peers/venv in cargo's target folder"
    parser.add_argument("--venv", type=Path, metavar="FOLDER", help=folder)
    return parser.parse_args()


def main():
    arguments = parse_arguments()
    enter_environment(arguments.venv or default_environment(), PACKAGES)
    import ducc0

    cases = []
    for case in [replace(case, leader=leader) for case in CASES for leader in ["ducc0", "sphvar"]]:
        if arguments.quick and case.n_points > QUICK_POINTS:
            continue
        if arguments.quick and case.sets > 1:
            case.sets = QUICK_SETS
        if re.search(arguments.only, case.name):
            cases.append(case)
    if not cases:
        sys.exit("no case of that name: " + ", ".join(case.name for case in CASES))

    ducc0.misc.set_heap_trim_limit(KEPT_MEMORY)
    environment = describe_environment()
    server = Server()
    print(", ".join(f"{key} {value}" for key, value in environment.items()))
    print("Milliseconds for one transform (of an ensemble: wall clock for all sets, two cores, over their number).")
    print("ducc0 is given angles; sphvar is given unit vectors and finds the angles within its time.\n")
    print(HEADER, flush=True)
    rows = []
    for case in cases:
        rows.append(measure(case, server))
        print(rows[-1].line(), flush=True)
    server.close()

    print("\nratio: of medians, the fastest rival of ducc0 over sphvar, whose error is no larger; see the docstring of the script;")
    print("required: the required ratio, or - where nothing is required.\n")
    print(f"References of the errors, and how far ducc0 at {FINEST_DUCC:g} and sphvar at {FINEST_SPHVAR:g} are apart:")
    columns = ["sphvar to ducc0", "ducc0 to exact", "sphvar to exact"]
    print(f"{'points/degree/target leader':<31} | {'reference':<16} | " + " | ".join(columns))
    for row in rows:
        numbers = [f"{row.distances[c]:.1e}" if c in row.distances else "-" for c in columns]
        cells = [f"{number:>{len(column)}}" for number, column in zip(numbers, columns, strict=True)]
        print(f"{row.case.name:<31} | {row.reference:<16} | " + " | ".join(cells))
    for row in rows:
        if row.case.sets > 1:
            rates = ", ".join(f"{c.label} {1 / c.median:.0f}" for c in [*row.duccs, row.ours])
            print(f"\n{row.case.sets} sets, sets a second: {rates}; ratio {row.ratio:.2f}")

    if arguments.json:
        record = {"environment": environment, "cases": [row.as_json() for row in rows]}
        arguments.json.write_text(json.dumps(record, indent=1) + "\n")
    complaints = [f"{row.case.name}: {complaint}" for row in rows for complaint in row.complaints]
    if complaints:
        sys.exit("\n".join(["the results disagree:", *complaints]))


if __name__ == "__main__":
    main()
