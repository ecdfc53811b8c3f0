"""Runs the parts of a plan of sphvar on the workers of Dask distributed, and merges them.

The workers see this folder under the same path. Without an address, the scheduler is that of the
configuration of Dask (DASK_SCHEDULER_ADDRESS), or a cluster on this machine.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

from distributed import Client, as_completed

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


def run_part(folder, part):
    """Run a part. One that is done takes no time, and interrupted work is continued."""
    status = subprocess.run(["sh", f"{folder}/part", str(part)], check=False).returncode
    if status != 0:
        raise RuntimeError(f"part {part} ended with status {status}")
    return part


def main():
    """Run the parts and the merge; the exit status is 0 if all succeed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("address", nargs="?", help="address of the scheduler, such as tcp://host:8786")
    parser.add_argument("--parts", type=parts_of, default=f"1-{PLAN['parts']}", help="such as 3,7-9 (default: all)")
    parser.add_argument("--retries", type=int, default=2, help="how often a failed part is run again (default: 2)")
    options = parser.parse_args()
    failed = 0
    with Client(options.address) as client:
        futures = client.map(run_part, [str(FOLDER)] * len(options.parts), options.parts, retries=options.retries, pure=False)
        for future in as_completed(futures):
            error = future.exception()
            if error is not None:
                failed += 1
                print(error, file=sys.stderr)
    if failed:
        sys.exit(f"{failed} of {len(options.parts)} parts failed; see: sphvar plan status {FOLDER}")
    sys.exit(subprocess.run(["sh", str(FOLDER / "merge")], check=False).returncode)


if __name__ == "__main__":
    main()
