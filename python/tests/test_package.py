"""What the package is made of: names, versions, licences, the contents of a wheel."""

import email
import os
import pathlib
import re
import subprocess
import sys
import zipfile
from importlib import metadata

import pytest

import sphvar

ROOT = pathlib.Path(__file__).parents[2]


def version_of(manifest: pathlib.Path, table: str) -> str:
    """Return the version that a table of a Cargo manifest states."""
    # `tomllib` is newer than the oldest interpreter.
    text = manifest.read_text()
    found = re.search(rf'^\[{re.escape(table)}\]\n(?:[^\[].*\n|\n)*?version = "(.*?)"', text, re.MULTILINE)
    assert found is not None, f"{manifest}: [{table}] states no version"
    return found[1]


def test_the_version_is_that_of_the_libraries() -> None:
    version = version_of(ROOT / "Cargo.toml", "workspace.package")
    assert version_of(ROOT / "python" / "Cargo.toml", "package") == version
    assert sphvar.__version__ == version


def test_licences_are_those_of_the_repository() -> None:
    for name in ("LICENSE-APACHE", "LICENSE-MIT"):
        assert (ROOT / "python" / name).read_bytes() == (ROOT / name).read_bytes()


def test_importing_is_fast_and_imports_no_plots() -> None:
    code = "import sys, sphvar; print([m for m in ('matplotlib', 'tqdm', 'scipy', 'pandas') if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert result.stdout == "[]\n"


def test_an_installed_package_describes_itself() -> None:
    try:
        of_package = metadata.metadata("sphvar")
    except metadata.PackageNotFoundError:
        pytest.skip("the package is not installed; it is imported from the source tree")
    assert of_package["Version"] == sphvar.__version__
    assert of_package["License-Expression"] == "MIT OR Apache-2.0"
    scripts = [entry.name for entry in metadata.entry_points(group="console_scripts") if entry.value == "sphvar._command:main"]
    assert scripts == ["sphvar"]


@pytest.fixture
def wheel() -> zipfile.ZipFile:
    """Return the wheel that the variable SPHVAR_WHEEL names."""
    path = os.environ.get("SPHVAR_WHEEL")
    if path is None:
        pytest.skip("SPHVAR_WHEEL names no wheel")
    return zipfile.ZipFile(path)


def test_a_wheel_is_for_every_cpython_from_3_10(wheel: zipfile.ZipFile) -> None:
    assert wheel.filename is not None
    name = pathlib.Path(wheel.filename).name
    assert re.fullmatch(rf"sphvar-{re.escape(sphvar.__version__)}-cp310-abi3-\w+\.whl", name), name
    described = email.message_from_bytes(wheel.read(f"sphvar-{sphvar.__version__}.dist-info/METADATA"))
    assert described["Requires-Python"] == ">=3.10"


def test_a_wheel_has_what_it_needs_and_nothing_else(wheel: zipfile.ZipFile) -> None:
    names = set(wheel.namelist())
    sources = {
        f"sphvar/{path.relative_to(ROOT / 'python' / 'sphvar').as_posix()}"
        for path in (ROOT / "python" / "sphvar").rglob("*")
        if path.suffix in (".py", ".pyi", ".typed") or path.name == "py.typed"
    }
    assert sources <= names
    folder = f"sphvar-{sphvar.__version__}.dist-info"
    for name in ("LICENSE-APACHE", "LICENSE-MIT", "LICENSES-THIRD-PARTY"):
        assert f"{folder}/licenses/{name}" in names
    others = names - sources
    modules = {name for name in others if re.fullmatch(r"sphvar/_sphvar\.(abi3\.so|pyd)", name)}
    assert len(modules) == 1
    unexpected = {name for name in others - modules if not name.startswith(folder)}
    # Bills of materials, which newer versions of the build tool add, lie in the folder of descriptions.
    assert unexpected == set()


def test_a_wheel_names_every_dependency_that_is_compiled_in(wheel: zipfile.ZipFile) -> None:
    text = wheel.read(f"sphvar-{sphvar.__version__}.dist-info/licenses/LICENSES-THIRD-PARTY").decode()
    for name in ("pyo3", "numpy", "rayon", "clap", "rustfft"):
        assert re.search(rf"^{name}-\d", text, re.MULTILINE), name


def test_a_wheel_has_no_path_of_the_machine_that_made_it(wheel: zipfile.ZipFile) -> None:
    home = os.fsencode(os.path.expanduser("~"))
    for name in wheel.namelist():
        if name.endswith((".py", ".pyi")):
            assert home not in wheel.read(name)
