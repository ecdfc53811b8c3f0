"""What the scripts beside this one ask of files: whether results are the same, and how often parts were started."""

import json
import re
import sys
from pathlib import Path


def content(path: Path) -> bytes:
    """Return the bytes of a result without its provenance, the command and the version that made it."""
    data = path.read_bytes()
    if path.suffix == ".csv":
        return b"".join(line for line in data.splitlines(True) if not line.startswith(b"# sphvar "))
    if path.suffix == ".json":
        # Numbers stay the digits that they are.
        document = json.loads(data, parse_float=str)
        document.pop("provenance", None)
        return json.dumps(document).encode()
    return data


def same(one: Path, other: Path) -> None:
    """Exit with an error unless two files, or the files of two folders, are the same."""
    files = {path.relative_to(one) for path in one.rglob("*") if path.is_file()} or {Path()}
    others = {path.relative_to(other) for path in other.rglob("*") if path.is_file()} or {Path()}
    if files != others:
        sys.exit(f"only one has {sorted(map(str, files ^ others))}")
    for file in sorted(files):
        if content(one / file) != content(other / file):
            sys.exit(f"{one / file} and {other / file} differ")
    size = sum((one / file).stat().st_size for file in files)
    print(f"{len(files)} files of {size} bytes are the same, apart from provenance")


def starts(job: Path) -> None:
    """Print how often the parts of a job were started."""
    logs = sorted(log for log in job.glob("logs/*.jsonl") if re.fullmatch(r"\d+", log.stem))
    print(sum('"event":"start"' in line.replace(" ", "") for log in logs for line in log.open()))


if __name__ == "__main__":
    question, *paths = sys.argv[1:]
    {"same": same, "starts": starts}[question](*map(Path, paths))
