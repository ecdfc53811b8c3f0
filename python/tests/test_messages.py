"""Messages name options as keywords, as calls have them."""

import re
import subprocess
import sys

import numpy as np
import pytest

import sphvar
from sphvar import _ask

POINTS = sphvar.Sampler("fibonacci", 64).random()[0]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: sphvar.spectrum(POINTS, 64), "the argument n cannot be used with source"),
        (
            lambda: sphvar.choose("fibonacci", integrand="cosine"),
            "the following required arguments were not provided: error or n",
        ),
        (
            lambda: sphvar.spectrum(POINTS, weights=np.where(np.arange(64) == 2, np.nan, 1)),
            "points[2]: w: expected a finite number, got NaN (skip_invalid=True skips such rows)",
        ),
        (
            lambda: sphvar.measure("fibonacci", n=64, integrand="cosine", realizations=0),
            "invalid value '0' for realizations: realizations must be at least 4 for the error of a "
            "measured variance, got 0",
        ),
        (
            lambda: sphvar.measure("fibonacci", integrand="cosine"),
            "missing required option n, the number of points",
        ),
        (
            lambda: sphvar.measure("fibonacci", n=64, integrand="cosine", seed=-1),
            "seed must be from 0 to 18446744073709551615, got -1",
        ),
        (
            lambda: sphvar.spectrum("jittered", 48, epsilon=3),
            "epsilon must be in [1e-13, 0.1], got 3.0",
        ),
    ],
)
def test_exceptions_name_keywords(call, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda: sphvar.Sampler("healpix", 200),
        lambda: sphvar.predict("healpix", n=200, integrand="cosine"),
        lambda: sphvar.rotations("healpix-hopf", 100),
    ],
)
def test_flags_are_truth_values(call):
    with pytest.raises(ValueError, match=r"\(use nearest=True\)"):
        call()


def test_warnings_name_keywords():
    with pytest.warns(sphvar.SphvarWarning, match=r"exceed max_points=100000; .*give atol=$"):
        sphvar.integrate("ylm:l=3,m=1", rtol=1e-8, max_points=100_000)


def test_texts_and_exceptions_of_others_stay_as_they_are():
    with pytest.raises(ValueError, match='unknown sampler "--seed"|"--seed"'):
        sphvar.predict("jittered", n="--seed", integrand="cosine")

    def fails(points):
        raise ValueError("give --seed")

    with pytest.raises(ValueError) as caught:
        sphvar.integrate(fails)
    assert caught.value.args == ("give --seed",)
    translate = _ask.Keywords(sphvar.choose).translate
    for text in ["a--seed b", "dir/--seed", '"--seed 3"', "--other 2", "1 --", "x-n"]:
        assert translate(text) == text


def test_keywords_of_the_table_are_options_of_the_command():
    """The letters, which the words of a question do not have, are those that the command has."""
    command = [sys.executable, "-m", "sphvar._command", "variance", "--help"]
    usage = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    for keyword, letter in _ask._LETTERS.items():
        assert re.search(rf"-{letter}, {_ask.flag(keyword)}\b", usage)


@pytest.mark.parametrize("seed", [1.5, "1", [0]])
def test_a_seed_is_a_whole_number(seed):
    for call in (
        lambda: sphvar.Sampler("jittered", 48, seed=seed),
        lambda: sphvar.spectrum("jittered", 48, seed=seed),
        lambda: sphvar.measure("jittered", n=48, integrand="cosine", seed=seed),
    ):
        with pytest.raises(TypeError, match="^seed: expected a whole number, got"):
            call()
