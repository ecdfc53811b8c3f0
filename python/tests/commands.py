"""The command that the tests compare with."""

import json
import os
import pathlib
import subprocess
import sys

import sphvar


def document(*words, folder=None):
    """Return the document that the command prints with ``--json``, in a folder of its own."""
    root = str(pathlib.Path(sphvar.__file__).parents[1])
    run = subprocess.run(
        [sys.executable, "-m", "sphvar._command", *words, "--json", "--quiet"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        env={**os.environ, "PYTHONPATH": root},
    )
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)
