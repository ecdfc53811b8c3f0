"""Questions: the same answers as the command, one's own arrays, and what calls reject."""

from __future__ import annotations

import _thread
import json
import os
import pickle
import threading
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import document
from hypothesis import given, settings
from hypothesis import strategies as st

import sphvar
from sphvar import _ask, _inputs, _sphvar

CAP = "cap:degrees=60"
FIXED_TIMES = {"seconds", "seconds_per_set", "seconds_in_all"}


def numbers(value: Any) -> Any:
    """Return a document without what is measured with a clock or states the run."""
    if isinstance(value, dict):
        left_out = FIXED_TIMES | {"provenance"}
        return {key: numbers(item) for key, item in value.items() if key not in left_out}
    if isinstance(value, list):
        return [numbers(item) for item in value]
    return value


# Each: the call, and the words of the command.
QUESTIONS: list[tuple[Any, str]] = [
    (lambda: sphvar.predict("fibonacci", n=[48, 96], integrand=CAP),
     "variance fibonacci -n 48,96 --integrand cap:degrees=60 --predict-only"),
    (lambda: sphvar.predict(["jittered", "healpix"], n=50, nearest=True, integrand="cosine", hemisphere=True),
     "variance jittered,healpix -n 50 --nearest --integrand cosine --hemisphere --predict-only"),
    (lambda: sphvar.predict("poisson-disk", n=24, integrand="vmf:kappa=9", spectrum_realizations=20, lmax=12),
     "variance poisson-disk -n 24 --integrand vmf:kappa=9 --spectrum-realizations 20 --lmax 12 --predict-only"),
    (lambda: sphvar.measure("jittered, white-noise", n=12, integrand=CAP, realizations=60, seed=3),
     "variance jittered,white-noise -n 12 --integrand cap:degrees=60 -m 60 --seed 3 --measure-only"),
    (lambda: sphvar.measure("sobol", n=16, integrand="disk:radius=0.3", realizations=60, square=True),
     "variance sobol -n 16 --integrand disk:radius=0.3 -m 60 --square --measure-only"),
    (lambda: sphvar.variance("jittered", n=48, integrand=CAP, realizations=60, project=1),
     "variance jittered -n 48 --integrand cap:degrees=60 -m 60 --project 1"),
    (lambda: sphvar.variance("fibonacci", n=31, integrand=CAP, hemisphere=True, realizations=60, visible_half=True),
     "variance fibonacci -n 31 --integrand cap:degrees=60 --hemisphere -m 60 --visible-half"),
    (lambda: sphvar.fixed_orientation("fibonacci", n=24, integrand="ylm:l=4,m=0", realizations=60),
     "variance fibonacci -n 24 --integrand ylm:l=4,m=0 -m 60 --no-rotate"),
    (lambda: sphvar.choose(["fibonacci", "white-noise"], integrand=CAP, n=60),
     "choose fibonacci,white-noise --integrand cap:degrees=60 -n 60"),
    (lambda: sphvar.choose("fibonacci, jittered", integrand="vmf:kappa=5", error=0.03, max_count=500),
     "choose fibonacci,jittered --integrand vmf:kappa=5 --error 0.03 --max-count 500"),
    (lambda: sphvar.progressive("halton", n=range(8, 33, 8), integrand=CAP, realizations=60),
     "progressive halton -n 8,16,24,32 --integrand cap:degrees=60 -m 60"),
    (lambda: sphvar.progressive("sobol", n=24, integrand="2 * vmf:kappa=3 @ 30/0", reference="none"),
     "progressive sobol -n 24 --integrand @ --reference none"),
]


@pytest.mark.parametrize("call, words", QUESTIONS)
def test_answers_are_those_of_the_command(call: Any, words: str, tmp_path: Path) -> None:
    expression = "2 * vmf:kappa=3 @ 30/0"
    expected = document(*[expression if word == "@" else word for word in words.split()], folder=tmp_path)
    assert numbers(call().to_dict()) == numbers(expected)
    assert list(tmp_path.iterdir()) == []


def test_a_comparison_is_that_of_the_command(tmp_path: Path) -> None:
    got = sphvar.compare("fibonacci, jittered", n=[12, 48], integrand=CAP, realizations=60, seed=7)
    words = f"compare fibonacci,jittered -n 12,48 --integrand {CAP} -m 60 --seed 7 -o out"
    expected = document(*words.split(), folder=tmp_path)
    assert numbers(got.to_dict()) == numbers(expected)


@pytest.mark.parametrize("weighted", [False, True])
def test_arrays_are_files(weighted: bool, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    points = rng.normal(size=(40, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    weights = rng.uniform(0.5, 2, size=40)
    columns = np.column_stack([points, weights]) if weighted else points
    names = "x,y,z,w" if weighted else "x,y,z"
    np.savetxt(tmp_path / "own.csv", columns, delimiter=",", header=names, comments="", fmt="%.17g")
    value = (points, weights) if weighted else points
    got = sphvar.variance({"own": value}, integrand=CAP, realizations=60).rows[0]
    words = f"variance file:own.csv --integrand {CAP} -m 60"
    [expected] = document(*words.split(), folder=tmp_path)["rows"]
    assert {**got, "sampler": ""} == {**expected, "sampler": ""}
    assert got["sampler"] == "own"
    assert (got["n_effective"] is None) is not weighted


def test_own_points_are_ranked_beside_patterns() -> None:
    points = sphvar.Sampler("fibonacci", 64).random(1)[0]
    samplers = {"mine": points, "fib": "fibonacci", "noise": sphvar.Sampler("white-noise", 64)}
    table = sphvar.predict(samplers, n=64, integrand=CAP)
    assert [row["sampler"] for row in table.rows] == ["mine", "fib", "noise"]
    mine, fib, noise = (row["predicted"] for row in table.rows)
    assert mine == pytest.approx(fib, rel=0.01) and fib < 0.1 * noise
    compared = sphvar.compare(samplers, n=64, integrand=CAP, realizations=60)
    assert [one["sampler"] for one in compared.samplers] == ["mine", "fib", "noise"]
    ranking = sphvar.choose(samplers, n=64, integrand=CAP)
    assert {row["sampler"] for row in ranking.rows} == {"mine", "fib", "noise"}
    assert ranking.rows[-1]["sampler"] == "noise"


def test_all_forms_of_samplers() -> None:
    points = np.eye(3)
    sets = np.stack([points, -points])

    def samplers(value: Any, **options: Any) -> list[tuple[str, int]]:
        rows = sphvar.predict(value, integrand="ylm:l=2,m=1", **options).rows
        return [(row["sampler"], row["n"]) for row in rows]

    assert samplers(points) == [("points", 3)]
    assert samplers(sets) == [("points", 3)]
    assert samplers([points, sets]) == [("points", 3), ("points-2", 3)]
    assert samplers((points, np.ones(3))) == [("points", 3)]
    assert samplers((points, -points)) == [("points", 3), ("points-2", 3)]
    assert samplers(points.tolist()) == [("points", 3)]
    assert samplers([points, "fibonacci"], n=7) == [("points", 3), ("fibonacci", 7)]
    assert samplers({"a, b": points, "c": "healpix"}, n=12) == [("a, b", 3), ("c", 12)]
    assert samplers(sphvar.Sampler("fibonacci", 9)) == [("fibonacci", 9)]
    assert samplers([sphvar.Sampler(points), sphvar.Sampler("step", 9, alpha=0.5)]) == [
        ("points", 3), ("step:alpha=0.5", 9)
    ]
    with pytest.raises(ValueError, match="different ones: 9, 12"):
        samplers([sphvar.Sampler("fibonacci", 9), sphvar.Sampler("healpix", 12)])
    assert samplers(points.astype(np.float32)[::-1]) == [("points", 3)]
    square = sphvar.measure(np.random.default_rng(1).random((5, 2)), integrand="disk:radius=0.3",
                            square=True, realizations=60)
    assert square.rows[0]["n"] == 5


def test_names_of_arrays_occur_in_no_text_of_the_call() -> None:
    points = np.eye(3)
    with pytest.raises(OSError, match="points"):
        sphvar.predict([points, "file:points"], integrand=CAP)


@pytest.mark.parametrize(
    "value, error, words",
    [
        (np.ones((4, 2)), ValueError, r"shape \(n, 3\).*square=True"),
        (np.ones(3), ValueError, "shape"),
        (np.zeros((0, 3)), ValueError, "point"),
        (np.array([[0, 0, np.nan]]), ValueError, "finite"),
        (np.array([["a", "b", "c"]]), TypeError, "array of points"),
        ((np.eye(3), np.ones(2)), ValueError, "weights"),
        ([], ValueError, "empty"),
        ({}, ValueError, "empty"),
        ("fibonaci", ValueError, "fibonacci"),
        ("-x", ValueError, "-x"),
    ],
)
def test_invalid_samplers(value: Any, error: type[Exception], words: str) -> None:
    with pytest.raises(error, match=words):
        sphvar.predict(value, n=12, integrand=CAP)


def test_unknown_keywords_name_the_close_ones() -> None:
    with pytest.raises(TypeError, match=r"measure\(\) has no keyword 'realisations'.*realizations"):
        sphvar.measure("jittered", n=12, integrand=CAP, realisations=10)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="until_rel"):
        sphvar.measure("jittered", n=12, integrand=CAP, until=0.1)  # type: ignore[call-arg]


def test_errors_are_those_of_the_command() -> None:
    with pytest.raises(ValueError, match="at least 4|must be at least"):
        sphvar.measure("jittered", n=12, integrand=CAP, realizations=1)
    with pytest.raises(ValueError, match="missing required option n, the"):
        sphvar.predict("fibonacci", integrand=CAP)
    with pytest.raises(ValueError, match="unknown|no integrand"):
        sphvar.predict("fibonacci", n=12, integrand="kap")
    with pytest.raises(OSError):
        sphvar.predict("file:missing.csv", integrand=CAP)


def test_parts_do_only_what_they_say() -> None:
    predicted = sphvar.predict("jittered", n=48, integrand=CAP)
    assert predicted.rows[0]["trials"] == 0 and np.isnan(predicted.measured).all()
    measured = sphvar.measure("jittered", n=48, integrand=CAP, realizations=60)
    assert measured.rows[0]["realizations"] == 0 and np.isnan(measured.predicted).all()


def test_results_are_pickled_and_equal() -> None:
    table = sphvar.predict("fibonacci", n=[12, 24], integrand=CAP)
    assert pickle.loads(pickle.dumps(table)).to_dict() == table.to_dict()
    assert "fibonacci" in repr(table)


def test_threads_have_the_same_answers() -> None:
    def ask() -> Any:
        table = sphvar.variance("jittered", n=[12, 48], integrand=CAP, realizations=60)
        return numbers(table.to_dict())

    expected, got = ask(), [None] * 4

    def run(i: int) -> None:
        got[i] = ask()

    threads = [threading.Thread(target=run, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert got == [expected] * 4


def test_progress_is_told_and_stops() -> None:
    told: list[tuple[float, float]] = []
    sphvar.measure("jittered", n=3072, integrand=CAP, realizations=2000,
                   progress=lambda *state: told.append(state))
    assert told and told[-1][0] > 0

    class Enough(Exception):
        pass

    def stop(done: float, expected: float) -> None:
        raise Enough

    start = time.monotonic()
    with pytest.raises(Enough):
        sphvar.measure("jittered", n=3072, integrand=CAP, realizations=1_000_000, progress=stop)
    assert time.monotonic() - start < 5
    with pytest.raises(TypeError, match="progress"):
        sphvar.measure("jittered", n=12, integrand=CAP, progress="yes")  # type: ignore[arg-type]


def test_interrupts_stop_trials() -> None:
    timer = threading.Timer(0.3, _thread.interrupt_main)
    timer.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sphvar.measure("jittered", n=3072, integrand=CAP, realizations=1_000_000)
    assert time.monotonic() - start < 5


class Recorder:
    """A session that records words and answers with a document."""

    def __init__(self, remarks: list[str]) -> None:
        self.words: list[str] = []
        self.said = remarks

    def answer(self, words: list[str]) -> str:
        self.words = words
        return "{}"

    def remarks(self) -> list[str]:
        return self.said


def test_warnings_of_the_command_are_warnings_at_the_call() -> None:
    session = Recorder(["a remark", "warning: the file has blanks"])
    with pytest.warns(sphvar.SphvarWarning, match="the file has blanks") as caught:
        assert _ask.ask("list", [], {}, session) == {}
    assert len(caught) == 1 and caught[0].filename == __file__


def test_values_become_words() -> None:
    options = {
        "n": range(16, 49, 16),
        "until_rel": 0.1,
        "lmax": np.int64(7),
        "epsilon": np.float32(0.5),
        "hemisphere": True,
        "square": np.False_,
        "kmax": None,
        "error": "1%",
        "degrees": np.array([1, 2]),
        "max_count": 1e5,
    }
    assert _ask.words("x", ["a"], options) == [
        "x", "a", "--count=16,32,48", "--until-rel=0.1", "--lmax=7", "--epsilon=0.5",
        "--hemisphere", "--error=1%", "--degrees=1,2", "--max-count=100000",
    ]
    for value in (b"7", {"a": 1}, object(), [None], [[True]]):
        with pytest.raises(TypeError, match="n: expected"):
            _ask.words("x", [], {"n": value})


@settings(max_examples=50, deadline=None)
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_keep_their_bits(value: float) -> None:
    [_, word] = _ask.words("x", [], {"error": value})
    assert np.float64(word.removeprefix("--error=")).tobytes() == np.float64(value).tobytes()


@settings(max_examples=25, deadline=None)
@given(
    counts=st.lists(st.integers(1, 10**6), min_size=1, max_size=8),
    seed=st.integers(0, 2**64 - 1),
)
def test_the_command_reads_the_words_back(counts: list[int], seed: int) -> None:
    words = _ask.words("list", ["samplers"], {"seed": seed})
    listed = json.loads(_sphvar.Session(None).answer(words))
    assert listed["provenance"]["seed"] == seed
    with pytest.raises(ValueError, match="expected numbers from 1") as caught:
        options = {"n": [*counts, "x"], "integrand": CAP, "predict_only": True}
        _sphvar.Session(None).answer(_ask.words("variance", ["fibonacci"], options))
    assert "x" in str(caught.value)


@settings(max_examples=30, deadline=None)
@given(st.text(min_size=1, max_size=12), st.lists(st.text(max_size=12), max_size=4))
def test_names_are_free(wanted: str, texts: list[str]) -> None:
    inputs = _inputs.Inputs(_sphvar.Session(None), texts)
    names = [inputs.name(wanted) for _ in range(3)]
    assert len(set(names)) == 3
    assert all(name not in text for name in names for text in texts)


def test_nothing_is_printed_or_written(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    before = os.getcwd()
    os.chdir(tmp_path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            sphvar.compare("fibonacci", n=12, integrand=CAP, realizations=60)
    finally:
        os.chdir(before)
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def test_options_of_samplers_are_those_of_questions_about_them() -> None:
    def measured(sampler: Any, **options: Any) -> Any:
        return sphvar.measure(sampler, n=48, integrand="cap:degrees=60", realizations=8, **options)

    sampler = sphvar.Sampler("jittered", 48, seed=3)
    assert measured(sampler) == measured("jittered", seed=3) != measured("jittered")
    assert measured(sampler, seed=4) == measured("jittered", seed=4)
    half = sphvar.Sampler("white-noise", 48, hemisphere=True)
    assert measured(half) == measured("white-noise", hemisphere=True)
    with pytest.raises(ValueError, match="seed: missing, and the samplers have different ones: 0, 3"):
        measured([sampler, sphvar.Sampler("fibonacci", 48)])
    with pytest.raises(ValueError, match="hemisphere: missing, and only some samplers have it"):
        measured([half, sampler], seed=0)
    long = sphvar.Sampler(2 * sphvar.Sampler("fibonacci", 48).random()[0], normalize=True)
    assert sphvar.quality(long).rows[0]["sampler"] == "points"
    white = sphvar.Sampler("white-noise", 48, seed=3)
    integral = sphvar.integrate("cosine", rtol=0.1, sampler=white)
    assert integral == sphvar.integrate("cosine", rtol=0.1, sampler="white-noise", seed=3)
