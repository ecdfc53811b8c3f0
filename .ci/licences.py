"""Copies the licences of all dependencies of the command from their packages.

Usage: licences.py FOLDER

FOLDER gets a folder of texts for each dependency, and the list DEPENDENCIES with the licence that each one declares.
"""

import json
import pathlib
import shutil
import subprocess
import sys

TEXTS = ("LICENSE*", "LICENCE*", "license*", "COPYING*", "COPYRIGHT*", "NOTICE*", "UNLICENSE*")


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


folder = pathlib.Path(sys.argv[1])
host = next(line.split()[1] for line in run("rustc", "-vV").splitlines() if line.startswith("host:"))
metadata = json.loads(run("cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", host))
packages = {package["id"]: package for package in metadata["packages"]}
nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
# What is linked into the command: normal dependencies, from the command down.
pending = [package["id"] for package in metadata["packages"] if package["name"] == "sphvar-cli"]
linked = set(pending)
while pending:
    for dependency in nodes[pending.pop()]["deps"]:
        is_normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
        if is_normal and dependency["pkg"] not in linked:
            linked.add(dependency["pkg"])
            pending.append(dependency["pkg"])

folder.mkdir(parents=True)
lines = []
for package in sorted((packages[id] for id in linked), key=lambda p: (p["name"], p["version"])):
    if package["source"] is None:
        continue
    name = f"{package['name']}-{package['version']}"
    root = pathlib.Path(package["manifest_path"]).parent
    texts = {path for pattern in TEXTS for path in root.glob(pattern) if path.is_file()}
    if package["license_file"]:
        texts.add(root / package["license_file"])
    for text in texts:
        (folder / name).mkdir(exist_ok=True)
        shutil.copy(text, folder / name / text.name)
    remark = "" if texts else " (the package contains no text)"
    lines.append(f"{name}: {package['license']}{remark}\n")
(folder / "DEPENDENCIES").write_text("".join(lines))
