"""What the scripts beside this one share: their virtual environment, the processes that run sphvar, the turns of the timing."""

import contextlib
import json
import os
import platform
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run_checked(command, failure):
    """The standard output of a command; leaves with `failure` and the end of its messages if it fails."""
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    except OSError as error:
        sys.exit(f"{failure}: {error}")
    if done.returncode != 0:
        sys.exit(f"{failure}:\n{(done.stderr or done.stdout)[-4000:]}")
    return done.stdout


def default_environment():
    command = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    metadata = json.loads(run_checked(command, "cargo metadata fails"))
    return Path(metadata["target_directory"]) / "peers" / "venv"


def enter_environment(folder, packages):
    """Runs the script again under an interpreter that has the packages, given as `name` or `name==version.*`."""
    if folder.exists() and os.path.samefile(sys.prefix, folder):
        return
    python = folder / "bin" / "python"
    wanted = [package.rstrip("*").partition("==")[::2] for package in packages]
    probe = "\n".join(
        ["import importlib"]
        + [f"assert importlib.import_module({name!r}).__version__.startswith({version!r})" for name, version in wanted]
    )
    if not python.exists() or subprocess.run([python, "-c", probe], capture_output=True, check=False).returncode != 0:
        print(f"installing {' and '.join(packages)} in {folder}", file=sys.stderr)
        if not python.exists():
            if folder.exists() and any(folder.iterdir()):
                sys.exit(f"{folder} is neither empty nor a virtual environment")
            make = [sys.executable, "-m", "venv", folder]
            run_checked(make, f"cannot make a virtual environment in {folder} (is python3-venv installed?)")
        install = [python, "-m", "pip", "install", "--quiet", *packages]
        run_checked(install, f"pip cannot install {' and '.join(packages)} in {folder} (is there a network?)")
        run_checked([python, "-c", probe], f"what is in {folder} cannot be used; remove that folder and run again")
    os.execv(python, [str(python), *sys.argv])


class Driver:
    """A process of an example of a package that carries out one command a line; see the head of the example."""

    def __init__(self, example, package="sphvar-tests"):
        command = ["cargo", "build", "--release", "-p", package, "--example", example]
        output = run_checked([*command, "--message-format", "json-render-diagnostics"], f"{example} does not build")
        messages = [json.loads(line) for line in output.splitlines()]
        (executable,) = [m["executable"] for m in messages if m.get("executable")]
        self.name = example
        self.process = subprocess.Popen([executable], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, *words):
        """The seconds that the command took, or None if it is not one that is timed."""
        with contextlib.suppress(BrokenPipeError):
            print(*words, file=self.process.stdin, flush=True)
        answer = self.process.stdout.readline().strip()
        if not answer:
            sys.exit(f"{self.name} died of: {' '.join(map(str, words))}")
        return None if answer == "ok" else float(answer)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def in_turn(rounds, contestants):
    """Calls each timed function twice a round, appends the seconds of the second call; each round begins with another.

    `contestants` are pairs: a list for the seconds, a function that returns them. The first call brings the processor
    back from the other process: awake, its caches filled.
    """
    for r in range(rounds):
        for k in range(len(contestants)):
            samples, timed = contestants[(r + k) % len(contestants)]
            timed()
            samples.append(timed())


def stopwatch(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


def describe_machine():
    cpu = platform.processor() or platform.machine()
    with contextlib.suppress(OSError):
        found = re.search(r"^model name\s*:\s*(.+)$", Path("/proc/cpuinfo").read_text(), re.MULTILINE)
        cpu = found[1] if found else cpu
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "load": f"{os.getloadavg()[0]:.1f}",
        "python": platform.python_version(),
        "rustc": run_checked(["rustc", "--version"], "rustc fails").split()[1],
    }
