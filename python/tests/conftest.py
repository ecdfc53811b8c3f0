"""What all tests share."""

import os
import pathlib
from collections.abc import Iterator

import matplotlib
import pytest

import sphvar

matplotlib.use("Agg")


@pytest.fixture(scope="session", autouse=True)
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Run in another folder: processes that tests start must import the package under test, not the source tree."""
    before = os.getcwd()
    os.environ["PYTHONPATH"] = str(pathlib.Path(sphvar.__file__).parents[1])
    os.chdir(tmp_path_factory.mktemp("elsewhere"))
    yield
    os.chdir(before)
