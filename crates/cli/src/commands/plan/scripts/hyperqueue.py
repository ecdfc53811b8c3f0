"""Submits the parts of a plan of sphvar to HyperQueue, with the merge after them, and waits for their end.

This uses the Python package of HyperQueue; `submit` uses the command hq where there is one.
"""

import argparse
import json
import sys
from pathlib import Path

from hyperqueue import Client, Job
from hyperqueue.ffi.protocol import ResourceRequest

FOLDER = Path(__file__).resolve().parent
PLAN = json.loads((FOLDER / "manifest.json").read_text(encoding="utf-8"))


def parts_of(text):
    """Return the parts of a list such as 3,7-9."""
    parts = []
    for item in text.split(","):
        first, _, last = item.partition("-")
        if not 1 <= int(first) <= int(last or first) <= PLAN["parts"]:
            raise argparse.ArgumentTypeError(f"expected parts from 1 to {PLAN['parts']}, got {text}")
        parts += range(int(first), int(last or first) + 1)
    return parts


def main():
    """Run the parts and the merge; the exit status is 0 if all succeed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("server", nargs="?", help="folder of the server (default: that of the configuration of hq)")
    parser.add_argument("--parts", type=parts_of, default=f"1-{PLAN['parts']}", help="such as 3,7-9 (default: all)")
    options = parser.parse_args()
    # A failed part must not end the others.
    job = Job(name=f"sphvar {FOLDER.name}", default_workdir=FOLDER, max_fails=None)
    cpus = PLAN["threads"] or "all"
    parts = [
        job.program(
            ["sh", str(FOLDER / "part"), str(part)],
            name=f"part {part}",
            stdout=None,
            stderr=None,
            resources=ResourceRequest(cpus=cpus),
        )
        for part in options.parts
    ]
    job.program(
        ["sh", str(FOLDER / "merge")],
        name="merge",
        stdout="logs/merge.out",
        stderr="logs/merge.err",
        deps=parts,
        resources=ResourceRequest(cpus=1),
    )
    client = Client(options.server)
    submitted = client.submit(job)
    if not client.wait_for_jobs([submitted], raise_on_error=False):
        sys.exit(f"parts or the merge failed; see: sphvar plan status {FOLDER}")


if __name__ == "__main__":
    main()
