"""Compares speed and accuracy of sphvar with those of its peers: HEALPix indexing, harmonics, transforms.

Usage: python3 benches/peers/accuracy.py [--quick] [--only indexing,harmonics,transforms] [--json FILE] [--venv FOLDER]

Times are medians of contestants that alternate, one thread each. Results are ratios of the time of a peer to that of
sphvar: above 1, sphvar is faster. Errors are those of the same calls.

  indexing    healpy and the crate cdshealpix, at nside 16, 1024 and 2^29, ring and nested order. From a direction to its
              pixel: sphvar and healpy.vec2pix are given the same unit vectors; healpy.ang2pix colatitudes and longitudes,
              cdshealpix longitudes and latitudes, which are made before the clock starts, and (vec2pix) cdshealpix vectors,
              whose angles it computes within its time. The requirement is 1.5 times the speed of the fastest.
              cdshealpix has no lists; sphvar is also timed one by one. Then the same pixels: how many are equal, and
              whether the others lie so near an edge that rounding explains them.
  harmonics   scipy.special and ducc0, with errors against the 25-digit table of crates/accuracy/data. ducc0 has no
              function for a single value; its alm2leg with one coefficient is the same for one order at many
              colatitudes. Arguments of all are made before the clock starts.
  transforms  ducc0, by the code of transforms.py beside this script, on a short list of its cases, by both rules.

healpy and scipy return new arrays; sphvar, cdshealpix and ducc0 write to allocated memory.

Exit status: 0 whether or not sphvar is as fast as required; 1 if something cannot be built or results disagree beyond
rounding or a promised error.
"""

import argparse
import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import harmonics
import indexing
import transforms
from environment import default_environment, enter_environment

PACKAGES = [*transforms.PACKAGES, "healpy==1.20.*", "scipy==1.17.*"]
TRANSFORMS = [
    transforms.Case(4096, 256, 1e-5, 21),
    transforms.Case(100_000, 1024, 1e-5, 7, 1.0),
    transforms.Case(100_000, 512, 1e-12, 7),
]
QUICK_ROUNDS = 5


def measure_transforms(_folder, quick):
    """Prints the section as it goes; returns what goes to a file, and complaints."""
    server = transforms.Server()
    print("Transforms of scattered points, milliseconds; see transforms.py for the rules")
    print(transforms.HEADER, flush=True)
    rows = []
    for case in TRANSFORMS:
        for leader in ["ducc0", "sphvar"]:
            rounds = QUICK_ROUNDS if quick else case.rounds
            rows.append(transforms.measure(replace(case, leader=leader, rounds=rounds), server))
            print(rows[-1].line(), flush=True)
    server.close()
    complaints = [f"{row.case.name}: {complaint}" for row in rows for complaint in row.complaints]
    return [row.as_json() for row in rows], complaints


SECTIONS = {"indexing": indexing.measure, "harmonics": harmonics.measure, "transforms": measure_transforms}


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0], epilog="The docstring of the script has the details.")
    parser.add_argument("--quick", action="store_true", help="fewer repeats")
    only = "sections, separated by commas; default: all"
    parser.add_argument("--only", default=",".join(SECTIONS), metavar="LIST", help=only)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write everything measured")
    folder = "the virtual environment, made if there is none; default: peers/venv in cargo's target folder"
    parser.add_argument("--venv", type=Path, metavar="FOLDER", help=folder)
    arguments = parser.parse_args()
    arguments.only = arguments.only.split(",")
    unknown = [name for name in arguments.only if name not in SECTIONS]
    if unknown:
        parser.error(f"no section {', '.join(unknown)}: there are {', '.join(SECTIONS)}")
    return arguments


def describe_environment():
    import healpy
    import scipy

    return transforms.describe_environment() | {"healpy": healpy.__version__, "scipy": scipy.__version__}


def main():
    arguments = parse_arguments()
    enter_environment(arguments.venv or default_environment(), PACKAGES)
    import ducc0

    ducc0.misc.set_heap_trim_limit(transforms.KEPT_MEMORY)
    record = {"environment": describe_environment()}
    print(", ".join(f"{key} {value}" for key, value in record["environment"].items()))
    complaints = []
    with tempfile.TemporaryDirectory(prefix="sphvar-peers-") as folder:
        for name in arguments.only:
            print(flush=True)
            record[name], found = SECTIONS[name](Path(folder), arguments.quick)
            complaints += found
    if arguments.json:
        arguments.json.write_text(json.dumps(record, indent=1) + "\n")
    if complaints:
        sys.exit("\n".join(["\nthe results disagree:", *complaints]))


if __name__ == "__main__":
    main()
