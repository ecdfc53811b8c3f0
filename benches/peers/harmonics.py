"""Compares associated Legendre functions with scipy and ducc0; part of accuracy.py, which documents it."""

import math
import statistics
from dataclasses import dataclass
from decimal import Decimal, getcontext

from environment import ROOT, Driver, in_turn, stopwatch

TABLE = ROOT / "crates" / "accuracy" / "data" / "associated_legendre.csv"
SEED = 20240919
EPSILON = 2.0**-52
# What sphvar promises, in units of epsilon (l + 1) times the local amplitude.
PROMISE = 4.0
# Values below the range of f64 are not compared.
SMALLEST = Decimal("1e-300")
DEGREES = [(0, 64), (255, 1000), (2047, 20000)]
ORDERS = [(256, 128), (1000, 500), (4096, 2048)]
N_COLATITUDES = 256
DEGREES_OF_SCIPY = 256
LMAXES = [64, 256, 1000]


@dataclass
class Place:
    l: int
    m: int
    theta: float
    # None where the table has none.
    exact: Decimal | None

    def __str__(self):
        return f"l = {self.l}, m = {self.m}, theta = {self.theta!r}"


def load_table():
    places = []
    for line in TABLE.read_text().splitlines():
        if line[:1].isdigit():
            l, m, theta, exact = line.split(",")
            places.append(Place(int(l), int(m), float(theta), Decimal(exact)))
    return places


class Errors:
    """Errors of values in units of epsilon (l + 1) times the amplitude: the value itself where the function decays
    (sin(theta) < m/(l + 1/2)), else the larger of it and its neighbour of one degree less. `absolute` is the largest in
    units of epsilon (l + 1) times what no function of the degree exceeds, sqrt((2l + 1)/(4 pi)): all that a transform
    needs, and what ducc0 is made for."""

    def __init__(self, places, values, below):
        self.worst, self.largest, self.absolute, self.failed, self.n = None, 0.0, 0.0, 0, 0
        squares = []
        for place, value, neighbour in zip(places, values, below, strict=True):
            if place.exact is None or abs(place.exact) < SMALLEST:
                continue
            self.n += 1
            amplitude = abs(place.exact)
            if math.sin(place.theta) * (place.l + 0.5) >= place.m:
                amplitude = max(amplitude, abs(Decimal(float(neighbour))))
            error = abs(Decimal(float(value)) - place.exact) if math.isfinite(value) else Decimal("Infinity")
            unit = EPSILON * (place.l + 1)
            ceiling = math.sqrt((2 * place.l + 1) / (4.0 * math.pi))
            self.absolute = max(self.absolute, float(error) / (unit * ceiling))
            if not error < amplitude:
                self.failed += 1
                continue
            units = float(error / amplitude) / unit
            squares.append(units**2)
            if self.worst is None or units > self.largest:
                self.worst, self.largest = place, units
        self.rms = math.sqrt(statistics.fmean(squares)) if squares else 0.0

    def as_json(self):
        return {
            "values": self.n,
            "maximum": self.largest,
            "rms": self.rms,
            "absolute": self.absolute if math.isfinite(self.absolute) else None,
            "worst": str(self.worst),
            "without a digit": self.failed,
        }


@dataclass
class Contestant:
    name: str
    errors: Errors
    # Seconds for all values, None where there is no comparable call.
    seconds: float | None

    def line(self, case, n_values, ours):
        nanoseconds = "-" if self.seconds is None else f"{1e9 * self.seconds / n_values:.1f}"
        ratio = "-" if self.seconds is None else f"{self.seconds / ours.seconds:.2f}"
        e = self.errors
        return (
            f"{case:<34} {self.name:<24} {nanoseconds:>8} {ratio:>6} {e.absolute:>8.2g} {e.largest:>8.2g} {e.rms:>8.2g}"
            f" {e.failed:>4} of {e.n:<4} {e.worst or ''}"
        )


class Case:
    """Places whose values every code finds, with a function and an own number of timed values.

    `rivals` are pairs by name: a function that prepares a call for places, and whether the call is timed."""

    def __init__(self, name, places, words, rivals, n_values):
        self.name, self.places, self.words, self.rivals, self.n_values = name, places, words, rivals, n_values

    def measure(self, driver, folder, rounds):
        import numpy as np

        path = folder / "places"
        np.array([[p.l, p.m, p.theta] for p in self.places], dtype="<f8").tofile(path)
        driver.ask("places", path)

        def ours(word):
            driver.ask(word)
            driver.ask("write", folder / "values")
            return np.fromfile(folder / "values", dtype="<f8")

        below = ours("below")
        samples = {"sphvar": []}
        turns = [(samples["sphvar"], lambda: driver.ask(self.words))]
        found = {"sphvar": ours(self.words)}
        for name, (prepare, is_timed) in self.rivals.items():
            call = prepare(self.places)
            found[name] = call()
            if is_timed:
                samples[name] = []
                turns.append((samples[name], lambda call=call: stopwatch(call)))
        in_turn(rounds, turns)
        medians = {name: statistics.median(times) for name, times in samples.items()}
        return [
            Contestant(name, Errors(self.places, values, below), medians.get(name)) for name, values in found.items()
        ]


def columns(places):
    import numpy as np

    return tuple(np.array([getattr(p, name) for p in places]) for name in ("l", "m", "theta"))


# Each of these returns a call without arguments that finds the values: arguments are made before the clock starts.


def scipy_one(places):
    """The ufunc over all places."""
    import scipy.special as special

    arguments = columns(places)
    return lambda: special.sph_legendre_p(*arguments).reshape(len(places))


def scipy_all(places):
    import scipy.special as special

    lmax = places[0].l
    return lambda: [special.sph_legendre_p_all(lmax, lmax, p.theta).reshape(lmax + 1, -1)[p.l, p.m] for p in places]


def ducc_order(places):
    """One coefficient, of the degree and order of the first place, on the rings of all colatitudes."""
    import ducc0
    import numpy as np

    l, m = places[0].l, places[0].m
    alm = np.zeros((1, l + 1), dtype=np.complex128)
    alm[0, l] = 1.0
    arguments = {
        "alm": alm,
        "lmax": l,
        "theta": np.array([p.theta for p in places]),
        "mval": np.array([m], dtype=np.uint64),
        "mstart": np.zeros(1, dtype=np.uint64),
        "nthreads": 1,
    }
    return lambda: ducc0.sht.alm2leg(**arguments)[0, :, 0].real


def ducc_one(places):
    calls = [ducc_order([place]) for place in places]
    return lambda: [call()[0] for call in calls]


def scipy_degrees(places):
    """The ufunc over all degrees of the order of the first place."""
    import numpy as np
    import scipy.special as special

    l, m = places[0].l, places[0].m
    arguments = np.arange(m, l + 1)[:, None], m, np.array([p.theta for p in places])
    return lambda: special.sph_legendre_p(*arguments).reshape(l + 1 - m, len(places))[-1]


def ducc_degrees(places):
    """One call for each degree."""
    l, m = places[0].l, places[0].m
    calls = [ducc_order([Place(k, m, p.theta, None) for p in places]) for k in range(m, l + 1)]
    return lambda: [call() for call in calls][-1]


def cases():
    import numpy as np

    table = load_table()
    rng = np.random.default_rng(SEED)
    for low, high in DEGREES:
        places = [p for p in table if low <= p.l <= high]
        # ducc0 has no function for one value; what it knows is shown without its time.
        rivals = {"scipy sph_legendre_p": (scipy_one, True), "ducc0 alm2leg": (ducc_one, False)}
        yield Case(f"one by one, l from {low} to {high}", places, "one", rivals, len(places))
    for l, m in ORDERS:
        known = [p for p in table if (p.l, p.m) == (l, m)]
        thetas = np.arccos(rng.uniform(-1.0, 1.0, N_COLATITUDES - len(known)))
        places = known + [Place(l, m, float(theta), None) for theta in thetas]
        rivals = {"scipy sph_legendre_p": (scipy_one, True), "ducc0 alm2leg": (ducc_order, True)}
        yield Case(f"l = {l}, m = {m} at {N_COLATITUDES} thetas", places, "order", rivals, len(places))
        # Neither has a function for this; scipy takes minutes for the larger ones.
        rivals = {"ducc0 alm2leg": (ducc_degrees, True)}
        if l <= DEGREES_OF_SCIPY:
            rivals["scipy sph_legendre_p"] = (scipy_degrees, True)
        n_values = (l + 1 - m) * len(places)
        yield Case(f"l = {m} to {l}, m = {m} at {N_COLATITUDES}", places, "degrees", rivals, n_values)
    for lmax in LMAXES:
        places = [p for p in table if p.l == lmax]
        n_values = len(places) * (lmax + 1) * (lmax + 2) // 2
        rivals = {"scipy sph_legendre_p_all": (scipy_all, True)}
        yield Case(f"all l, m to {lmax} at {len(places)} thetas", places, "all", rivals, n_values)


def measure(folder, quick):
    """Prints the section as it goes; returns what goes to a file, and complaints."""
    getcontext().prec = 40
    driver = Driver("harmonics_server")
    rounds = 5 if quick else 11
    record, complaints = [], []
    print("Associated Legendre functions; ns: for one value; ratio: time over sphvar's. Errors against the 25-digit table:")
    print("absolute: in units of epsilon (l + 1) sqrt((2l + 1)/(4 pi)); maximum, rms: in units of epsilon (l + 1) times the")
    print("local amplitude, of the values that have a right digit; failed: those that have none or are not a number")
    header = f"{'case':<34} {'code':<24} {'ns':>8} {'ratio':>6} {'absolute':>8} {'maximum':>8} {'rms':>8} {'failed':>9}"
    print(f"{header}    worst of the others", flush=True)
    for case in cases():
        contestants = case.measure(driver, folder, rounds)
        for contestant in contestants:
            print(contestant.line(case.name, case.n_values, contestants[0]), flush=True)
        ours = contestants[0].errors
        if ours.failed or ours.largest > PROMISE:
            complaints.append(f"{case.name}: sphvar is off by {ours.largest:.2g} units and fails {ours.failed} times")
        codes = {c.name: {"seconds": c.seconds} | c.errors.as_json() for c in contestants}
        record.append({"case": case.name, "values": case.n_values, "codes": codes})
    driver.close()
    return record, complaints
