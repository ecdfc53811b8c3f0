"""Copies the licences of all dependencies of a package from theirs.

Usage: licences.py [--manifest-path MANIFEST] [--package NAME] (--folder FOLDER | --file FILE)

FOLDER gets a folder of texts for each dependency, and the list DEPENDENCIES with the licence that each one declares.
FILE gets the same list, and after it each different text once. The default is the command, `sphvar-cli`.
"""

import argparse
import json
import pathlib
import shutil
import subprocess

TEXTS = ("LICENSE*", "LICENCE*", "license*", "COPYING*", "COPYRIGHT*", "NOTICE*", "UNLICENSE*")


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def linked_packages(manifest, root):
    """Returns what is linked into a package from other sources: normal dependencies, from it down."""
    host = next(line.split()[1] for line in run("rustc", "-vV").splitlines() if line.startswith("host:"))
    metadata = json.loads(
        run(
            *("cargo", "metadata", "--locked", "--format-version", "1"),
            *("--manifest-path", manifest, "--filter-platform", host),
        )
    )
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    pending = [package["id"] for package in metadata["packages"] if package["name"] == root]
    if not pending:
        raise SystemExit(f"{manifest} has no package {root}")
    linked = set(pending)
    while pending:
        for dependency in nodes[pending.pop()]["deps"]:
            is_normal = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if is_normal and dependency["pkg"] not in linked:
                linked.add(dependency["pkg"])
                pending.append(dependency["pkg"])
    others = (packages[id] for id in linked if packages[id]["source"] is not None)
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def texts_of(package):
    """Returns the files of a package that are its licence."""
    root = pathlib.Path(package["manifest_path"]).parent
    texts = {path for pattern in TEXTS for path in root.glob(pattern) if path.is_file()}
    if package["license_file"]:
        texts.add(root / package["license_file"])
    return sorted(texts)


def title(package):
    return f"{package['name']}-{package['version']}"


def listed(packages):
    """Returns the list of the packages with the licences that they declare."""
    lines = []
    for package in packages:
        remark = "" if texts_of(package) else " (the package contains no text)"
        lines.append(f"{title(package)}: {package['license']}{remark}\n")
    return "".join(lines)


def write_folder(packages, folder):
    folder.mkdir(parents=True)
    for package in packages:
        for text in texts_of(package):
            (folder / title(package)).mkdir(exist_ok=True)
            shutil.copy(text, folder / title(package) / text.name)
    (folder / "DEPENDENCIES").write_text(listed(packages))


def write_file(packages, file):
    # Many packages have the same text.
    owners = {}
    for package in packages:
        for path in texts_of(package):
            text = path.read_text(errors="replace").replace("\r\n", "\n").strip()
            owners.setdefault(text, []).append(f"{title(package)}/{path.name}")
    rule = "-" * 100
    parts = ["Licences of the Rust packages that are compiled into sphvar.\n\n", listed(packages)]
    parts.extend(f"\n{rule}\n{', '.join(names)}\n{rule}\n\n{text}\n" for text, names in owners.items())
    file.write_text("".join(parts))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--manifest-path", default="Cargo.toml")
    parser.add_argument("--package", default="sphvar-cli")
    output = parser.add_mutually_exclusive_group(required=True)
    output.add_argument("--folder", type=pathlib.Path)
    output.add_argument("--file", type=pathlib.Path)
    options = parser.parse_args()
    packages = linked_packages(options.manifest_path, options.package)
    if options.folder:
        write_folder(packages, options.folder)
    else:
        write_file(packages, options.file)


main()
