#!/usr/bin/env python3
"""The error of `choose`'s best pattern over that of the best of a grid of every pattern's parameters.

    choose_study.py [--binary PATH] [--count 200,500,2000] [--integrand SPEC]...

The ratio should be at most 1.2, for `vmf:kappa=50` at N = 500 at most 1.05. Alpha has one value per last
empty degree from 0.7 sqrt(N) on.
"""

import argparse
import json
import math
import subprocess

INTEGRANDS = [
    "vmf:kappa=10",
    "vmf:kappa=50",
    "cap:degrees=60",
    "cap:degrees=25 @ 30/0 * cosine",
    "env:data/city.exr",
]
PLAIN = ["white-noise", "jittered", "healpix", "fibonacci", "spiral", "sobol", "halton", "hammersley"]
PARAMETERS = [
    "equal-area:placement=jittered",
    "equal-area:placement=centred",
    *(f"ccvt:capacity={c},mass={m}" for c in (16, 64, 256) for m in ("white", "fibonacci")),
    *(f"poisson-disk:mode=exact,radius={r}" for r in (1.6, 2.0, 2.4, 2.6)),
    *(f"riesz:s={s}" for s in (0, 1, 2)),
    "best-candidate:factor=1",
    "best-candidate:factor=4",
    "lloyd:iterations=10",
    "lloyd:iterations=100",
    "profile",
]


def alphas(n):
    root = math.sqrt(n)
    degrees = range(math.ceil(0.7 * root), math.ceil(math.sqrt(2) * root))
    for degree in degrees:
        alpha = next(
            a
            for digits in range(1, 8)
            for a in [math.ceil(degree / root * 10**digits) / 10**digits]
            if math.floor(a * root) == degree
        )
        yield from (f"{name}:alpha={alpha}" for name in ("step", "blue"))


def choose(arguments, spec, n, samplers=()):
    command = [arguments.binary, "choose", "--integrand", spec, "-n", str(n), "--json", "--quiet"]
    if samplers:
        command += ["--samplers", ",".join(samplers)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        return None
    rows = json.loads(done.stdout)["rows"]
    return next((row["sampler"], row["error"]) for row in rows if row["error"] is not None)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", default="target/release/sphvar")
    parser.add_argument("--count", default="200,500,2000")
    parser.add_argument("--integrand", action="append")
    parser.add_argument("--grid-only", action="store_true", help="not choose's own answer")
    arguments = parser.parse_args()
    print(f"{'integrand':<32} {'N':>5}  {'chosen':<22} {'error':>9}  {'best of grid':<28} {'error':>9}  ratio")
    for n in map(int, arguments.count.split(",")):
        for spec in arguments.integrand or INTEGRANDS:
            one_by_one = (choose(arguments, spec, n, [s]) for s in [*PLAIN, *PARAMETERS, *alphas(n)])
            name, least = min((row for row in one_by_one if row), key=lambda row: row[1])
            chosen, error = ("-", math.nan) if arguments.grid_only else choose(arguments, spec, n)
            ratio = error / least if least > 0 else (1.0 if error == 0 else math.inf)
            print(
                f"{spec:<32} {n:>5}  {chosen:<22} {error:9.2e}  {name:<28} {least:9.2e}  {ratio:.3f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
