"""Executes the notebooks of docs/notebooks from their sources, the scripts beside them.

Usage: notebooks.py [--check] [NAME...]

Without --check, writes NAME.ipynb with its outputs. With it, executes the scripts and compares the texts that they
print with those of the notebooks, numbers to a relative 1e-6; lines with times are not compared. Figures must be
drawn, and are not compared.
"""

import argparse
import math
import os
import pathlib
import re
import sys
import time

import jupytext
import nbclient
import nbformat

FOLDER = pathlib.Path(__file__).parents[1] / "docs" / "notebooks"
LARGEST = 200_000
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
# Lines with these words have measured times.
TIME = re.compile(r"\b(time|times|ms|us|seconds?|s)\b")


def executed(source):
    """Returns the notebook of a script after its execution."""
    notebook = jupytext.read(source)
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    for number, cell in enumerate(notebook.cells):
        cell.id = f"cell-{number}"
        cell.metadata = {}
    client = nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(FOLDER)}})
    client.execute()
    for cell in notebook.cells:
        cell.metadata = {}
    return notebook


def texts(cell):
    """Returns the printed text of a cell, and the number of its figures."""
    lines, figures = [], 0
    for output in cell.get("outputs", []):
        if output.output_type == "stream" and output.name == "stderr":
            raise SystemExit(f"a cell writes to standard error:\n{cell.source}\n{output.text}")
        text = output.get("text") or output.get("data", {}).get("text/plain", "")
        if "image/png" in output.get("data", {}):
            figures += 1
        else:
            lines.extend(text.splitlines())
    return lines, figures


def is_same(line, other):
    """Tests whether two lines have the same words, and numbers that differ by rounding."""
    if NUMBER.split(line) != NUMBER.split(other):
        return False
    pairs = zip(NUMBER.findall(line), NUMBER.findall(other), strict=True)
    return all(math.isclose(float(a), float(b), rel_tol=1e-6) for a, b in pairs)


def differences(new, old):
    """Yields what differs between a notebook and the committed one."""
    if [cell.source for cell in new.cells] != [cell.source for cell in old.cells]:
        yield "the cells of the notebook are not those of the script"
        return
    for cell, before in zip(new.cells, old.cells, strict=True):
        (lines, figures), (expected, drawn) = texts(cell), texts(before)
        lines, expected = ([x for x in y if not TIME.search(x)] for y in (lines, expected))
        if figures != drawn:
            yield f"{figures} figures, expected {drawn}, of:\n{cell.source}"
        if len(lines) != len(expected):
            yield f"{len(lines)} lines, expected {len(expected)}, of:\n{cell.source}"
        else:
            pairs = zip(lines, expected, strict=True)
            yield from (f"{a}\nexpected\n{b}" for a, b in pairs if not is_same(a, b))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    parser.add_argument("names", nargs="*")
    options = parser.parse_args()
    # The kernel is the interpreter that runs this script.
    os.environ["PATH"] = f"{pathlib.Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    sources = sorted(FOLDER.glob("*.py"))
    if options.names:
        sources = [source for source in sources if source.stem in options.names]
    if not sources:
        raise SystemExit(f"no scripts in {FOLDER}")
    failed = False
    for source in sources:
        start = time.monotonic()
        notebook = executed(source)
        path = source.with_suffix(".ipynb")
        if options.check:
            for difference in differences(notebook, nbformat.read(path, as_version=4)):
                failed = True
                print(f"{path.name}: {difference}")
        else:
            nbformat.write(notebook, path)
        if (size := path.stat().st_size) > LARGEST:
            failed = True
            print(f"{path.name} has {size} bytes, more than {LARGEST}")
        print(f"{source.name}: {time.monotonic() - start:.1f} s", flush=True)
    if failed:
        raise SystemExit("notebooks differ; `just notebooks` writes them")


main()
