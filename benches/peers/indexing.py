"""Compares HEALPix indexing with healpy and the crate cdshealpix; part of accuracy.py, which documents it."""

import math
import statistics
from dataclasses import dataclass

from environment import Driver, in_turn, stopwatch

SEED = 20240918
N_RANDOM = 1 << 15
N_HARD = 1 << 15
NSIDES = [16, 1024, 2**29]
# The required ratio of the time of healpy or cdshealpix to that of sphvar, from a direction to its pixel.
REQUIRED_RATIO = 1.5
# Rounded angles put a place up to this far from its true one, in radians: a longitude up to 2 pi is rounded to 2 epsilon
# or so, and each code adds as much. A radian has up to 1.3 nside pixels.
SLACK = 4.0 * 2.0**-52
# Directions of pixel centres: healpy rounds longitudes up to 2 pi three times.
CENTRE_SLACK = 16.0 * 2.0**-52


def random_directions(rng):
    import numpy as np

    xyz = rng.standard_normal((N_RANDOM, 3))
    return xyz / np.linalg.norm(xyz, axis=1, keepdims=True)


def hard_directions(rng):
    """Places at and within 1e-16 to 0.1 of poles, of the border between caps and belt, of the equator and of the meridians
    between faces, in all combinations."""
    import numpy as np

    def nearby(values):
        offset = 10.0 ** -rng.uniform(1.0, 17.0, N_HARD) * rng.choice([-1.0, 0.0, 1.0], N_HARD)
        return rng.choice(values, N_HARD) + offset

    anywhere = rng.random(N_HARD) < 0.25
    theta = nearby([0.0, math.acos(2.0 / 3.0), math.pi / 2.0, math.acos(-2.0 / 3.0), math.pi])
    phi = np.where(anywhere, rng.uniform(0.0, 2.0 * math.pi, N_HARD), nearby(np.arange(8) * math.pi / 4.0))
    xyz = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)
    # Exactly on the axes and on the border too.
    xyz[:6] = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    return xyz


@dataclass
class Conversion:
    """What is timed: the name, sphvar's words, and for each rival its name and words or a function of healpy."""

    name: str
    ours: str
    cdshealpix: list
    healpy: list
    required_ratio: float | None = None


# Where a rival has several functions for the same conversion, all are timed.
CONVERSIONS = [
    Conversion("direction to pixel", "vec2pix", ["lonlat2pix", "vec2pix"], ["vec2pix", "ang2pix"], REQUIRED_RATIO),
    Conversion("the same, one by one", "vec2pix-one", ["lonlat2pix"], []),
    Conversion("angles to pixel", "ang2pix", ["lonlat2pix"], ["ang2pix"], REQUIRED_RATIO),
    Conversion("the same, one by one", "ang2pix-one", ["lonlat2pix"], []),
    Conversion("pixel to direction", "pix2vec", ["pix2vec"], ["pix2vec"]),
]


@dataclass
class Row:
    conversion: str
    nside: int
    order: str
    # Seconds for each point by contestant, the first ours.
    seconds: dict
    required_ratio: float | None

    @property
    def ratios(self):
        ours, *_ = self.seconds.values()
        return {name: seconds / ours for name, seconds in list(self.seconds.items())[1:]}

    @property
    def ratio(self):
        return min(self.ratios.values())

    @property
    def verdict(self):
        if self.required_ratio is None:
            return ""
        return f"required {self.required_ratio}: " + ("met" if self.ratio >= self.required_ratio else "missed")

    def line(self):
        ours, *_ = self.seconds.values()
        parts = ", ".join(f"{name} {ratio:.2f}" for name, ratio in self.ratios.items())
        name = f"{self.conversion}, {self.order}"
        return f"{name:<30} {self.nside:>9} {1e9 * ours:8.1f} {self.ratio:6.2f}  {parts}  {self.verdict}".rstrip()


@dataclass
class Agreement:
    """How many results differ from ours, and how far those places are from an edge of their pixel, over the slack."""

    what: str
    nside: int
    order: str
    n: int
    different: dict
    # 1 is as far as rounding may explain.
    furthest: dict

    def line(self):
        parts = []
        for name, count in self.different.items():
            away = f" (the rest within {self.furthest[name]:.2f} of the rounding)" if count else ""
            parts.append(f"{name} {self.n - count}{away}")
        return f"{self.what:<14} {self.order:<6} {self.nside:>9}  " + ", ".join(parts)

    def as_json(self):
        """Returns the fields; infinity, the distance of a pixel that should be bit-identical but is not, becomes null."""
        return vars(self) | {"furthest": {k: v if math.isfinite(v) else None for k, v in self.furthest.items()}}


class Section:
    """Everything at one resolution and order."""

    def __init__(self, driver, folder, nside, order, rng):
        import numpy as np

        self.driver, self.folder, self.nside, self.order = driver, folder, nside, order
        self.nested = order == "nested"
        driver.ask("nside", nside)
        self.pixels = rng.integers(0, 12 * nside**2, N_RANDOM)
        self.pixels.astype("<u8").tofile(folder / "pixels")
        driver.ask("pixels", folder / "pixels")

    def take(self, xyz):
        """Makes these the directions of all contestants, angles for those who want them."""
        import numpy as np

        self.xyz = np.ascontiguousarray(xyz.T)
        x, y, z = self.xyz
        self.phi = np.arctan2(y, x)
        self.phi = np.where(self.phi < 0.0, self.phi + 2.0 * math.pi, self.phi)
        self.theta = np.arctan2(np.hypot(x, y), z)
        lat = np.arctan2(z, np.hypot(x, y))
        for name, columns in [("vectors", [x, y, z]), ("angles", [self.theta, self.phi]), ("lonlat", [self.phi, lat])]:
            np.stack(columns, axis=1).astype("<f8").tofile(self.folder / name)
            self.driver.ask(name, self.folder / name)

    def healpy(self, what):
        import healpy as hp

        inputs = {"vec2pix": self.xyz, "ang2pix": [self.theta, self.phi], "pix2vec": [self.pixels]}[what]
        return getattr(hp, what)(self.nside, *inputs, nest=self.nested)

    def run(self, code, what):
        return self.driver.ask("run", code, what, self.order)

    def result(self, dtype):
        import numpy as np

        path = self.folder / "result"
        self.driver.ask("write", path)
        return np.fromfile(path, dtype=dtype)

    def time(self, conversion, rounds):
        contestants = {"sphvar": lambda: self.run("sphvar", conversion.ours)}
        for what in conversion.healpy:
            contestants[f"healpy {what}"] = lambda what=what: stopwatch(self.healpy, what)
        for what in conversion.cdshealpix:
            contestants[f"cdshealpix {what}"] = lambda what=what: self.run("cdshealpix", what)
        samples = {name: [] for name in contestants}
        in_turn(rounds, [(samples[name], timed) for name, timed in contestants.items()])
        seconds = {name: statistics.median(times) / N_RANDOM for name, times in samples.items()}
        return Row(conversion.name, self.nside, self.order, seconds, conversion.required_ratio)

    def agree_on_pixels(self, kind, what):
        """Whether all find the pixels of the vectors (vec2pix) or of their angles (ang2pix)."""
        import numpy as np

        def of(code, conversion):
            self.run(code, conversion)
            return self.result("<u8").astype(np.int64)

        ours = of("sphvar", what)
        one_by_one = f"{what} one by one"
        theirs = {
            one_by_one: of("sphvar", f"{what}-one"),
            "healpy": self.healpy(what),
            "cdshealpix": of("cdshealpix", "lonlat2pix"),
        }
        self.driver.ask("edges", self.folder / "edges")
        edges = np.fromfile(self.folder / "edges", dtype="<f8") / (1.3 * self.nside * SLACK)
        different = {name: pixels != ours for name, pixels in theirs.items()}
        counts = {name: int(off.sum()) for name, off in different.items()}
        furthest = {name: float(edges[off].max(initial=0.0)) for name, off in different.items()}
        # These are bit-identical.
        furthest[one_by_one] = math.inf if counts[one_by_one] else 0.0
        return Agreement(f"{kind} {what}", self.nside, self.order, len(ours), counts, furthest)

    def centres(self):
        """How far the directions of centres are from ours, in units of epsilon."""
        import numpy as np

        self.run("sphvar", "pix2vec")
        ours = self.result("<f8").reshape(-1, 3)
        self.run("cdshealpix", "pix2vec")
        theirs = {"healpy": np.stack(self.healpy("pix2vec"), axis=1), "cdshealpix": self.result("<f8").reshape(-1, 3)}
        return {name: float(np.abs(xyz - ours).max()) for name, xyz in theirs.items()}


def measure(folder, quick):
    """Prints the section as it goes; returns what goes to a file, and complaints."""
    import numpy as np

    rng = np.random.default_rng(SEED)
    random, hard = random_directions(rng), hard_directions(rng)
    driver = Driver("indexing_server")
    rounds = 11 if quick else 41
    rows, agreements, centres, complaints = [], [], [], []
    print(f"HEALPix indexing: {N_RANDOM} random places; ratio: the fastest rival's time over sphvar's")
    print(f"{'conversion, order':<30} {'nside':>9} {'sphvar':>8} {'ratio':>6}  each rival's time over sphvar's")
    print(f"{'':<30} {'':>9} {'ns':>8}")
    for conversion in CONVERSIONS:
        for nside in NSIDES:
            for order in ["ring", "nested"]:
                section = Section(driver, folder, nside, order, rng)
                section.take(random)
                rows.append(section.time(conversion, rounds))
                print(rows[-1].line(), flush=True)
    print(f"\nEqual pixels, of {N_RANDOM}; hard: at and near poles, equator, borders of caps, meridians between faces, where places")
    print("lie on edges; rounding: how far from an edge it may bring a place to the other side")
    for nside in NSIDES:
        for order in ["ring", "nested"]:
            section = Section(driver, folder, nside, order, rng)
            for kind, xyz in [("random", random), ("hard", hard)]:
                section.take(xyz)
                for what in ["vec2pix", "ang2pix"]:
                    agreement = section.agree_on_pixels(kind, what)
                    agreements.append(agreement)
                    print(agreement.line(), flush=True)
                    for name, furthest in agreement.furthest.items():
                        if furthest > 1.0:
                            complaints.append(f"{kind} {what}, nside {nside}, {order}: not as {name}, beyond rounding")
            centres.append({"nside": nside, "order": order, "off": section.centres()})
    print("\nDirections of centres, largest difference of a component in units of epsilon = 2^-52")
    for centre in centres:
        off = {name: value / 2.0**-52 for name, value in centre["off"].items()}
        print(f"{centre['order']:<6} {centre['nside']:>9}  " + ", ".join(f"{k} {v:.1f}" for k, v in off.items()))
        for name, value in centre["off"].items():
            if value > CENTRE_SLACK:
                complaints.append(f"centres at nside {centre['nside']}, {centre['order']}, are {value:.1e} from {name}")
    driver.close()
    record = {
        "times": [vars(row) | {"ratio": row.ratio} for row in rows],
        "agreement": [agreement.as_json() for agreement in agreements],
        "centres": centres,
    }
    return record, complaints
