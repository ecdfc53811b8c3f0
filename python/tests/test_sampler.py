"""Samplers: the bytes of the command, numbered sets, weights, pickling, errors, memory."""

import copy
import multiprocessing
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sphvar
from sphvar import Sampler

SPECS = [
    ("white-noise", 100, {}),
    ("fibonacci", 50, {"rotate": True}),
    ("jittered", 54, {"hemisphere": True}),
    ("poisson-disk", 60, {}),
    ("step:alpha=1", 64, {}),
    ("gauss-legendre", 72, {"rotate": True}),
    ("sobol:warp=cosine", 32, {"hemisphere": True}),
    ("sobol", 32, {"square": True, "shift": True}),
    ("healpix", 100, {"nearest": True}),
    ("design:t=5", None, {}),
]


def command(*words: str) -> None:
    subprocess.run([sys.executable, "-m", "sphvar._command", *words, "--quiet"], check=True)


@pytest.mark.parametrize(("spec", "n", "options"), SPECS)
def test_sets_have_the_bytes_of_the_command(
    spec: str, n: int | None, options: dict[str, bool], tmp_path: Path
) -> None:
    flags = [f"--{key}" for key, value in options.items() if value]
    count = [] if n is None else ["-n", str(n)]
    path = tmp_path / "sets.npz"
    command("sample", spec, *count, "-m", "3", "-s", "7", "-o", str(path), *flags)
    sampler = Sampler(spec, n, seed=7, **options)
    points = sampler.random(3)
    with np.load(path) as file:
        assert points.tobytes() == file["points"].tobytes()
        assert points.shape == file["points"].shape == (3, sampler.n, 2 if sampler.square else 3)
        if "weights" in file:
            assert sampler.weights.tobytes() == file["weights"].tobytes()
        else:
            assert sampler.weights is None
    weights = sampler.weights
    # In other parts, by one thread, and from the middle.
    sampler.reset()
    parts = [sampler.random(2), sampler.random()]
    assert np.concatenate(parts).tobytes() == points.tobytes()
    if weights is not None:
        assert sampler.weights.tobytes() == weights[2:].tobytes()
    assert sampler.reset().fast_forward(2).random(1).tobytes() == points[2:].tobytes()


def test_many_sets_do_not_depend_on_threads() -> None:
    sampler = Sampler("poisson-disk", 200, seed=3)
    expected = sampler.random(40)
    single = np.concatenate([sampler.reset().fast_forward(i).random(1) for i in range(40)])
    assert single.tobytes() == expected.tobytes()
    try:
        for threads in [1, 3]:
            sphvar.set_num_threads(threads)
            assert sampler.reset().random(40).tobytes() == expected.tobytes()
    finally:
        sphvar.set_num_threads(0)


@settings(max_examples=30, deadline=None)
@given(parts=st.lists(st.integers(1, 5), min_size=1, max_size=6), seed=st.integers(0, 2**64 - 1))
def test_any_split_into_calls_gives_the_same_sets(parts: list[int], seed: int) -> None:
    sampler = Sampler("jittered", 12, seed=seed, rotate=True)
    whole = sampler.random(sum(parts))
    sampler.reset()
    split = np.concatenate([sampler.random(part) for part in parts])
    assert split.tobytes() == whole.tobytes()
    assert sampler.position == sum(parts)


def test_points_are_unit_vectors_and_sets_differ() -> None:
    points = Sampler("white-noise", 500).random(4)
    np.testing.assert_allclose(np.linalg.norm(points, axis=2), 1, rtol=0, atol=1e-15)
    assert points.flags.c_contiguous and points.flags.writeable and points.dtype == np.float64
    assert len({one.tobytes() for one in points}) == 4


def test_given_points(tmp_path: Path) -> None:
    points = Sampler("white-noise", 200, seed=1).random()[0]
    # Points that are read are normalized, which changes the last bit of some.
    points = points[(Sampler(points).random()[0] == points).all(axis=1)]
    sets = points[:60].reshape(3, 20, 3)
    sampler = Sampler(sets)
    assert sampler.n == 20
    assert sampler.random().tobytes() == sets.tobytes()
    assert sampler.position == 3
    # With m, sets are drawn uniformly, as by the command.
    np.save(tmp_path / "sets.npy", sets)
    command(
        "sample", f"file:{tmp_path / 'sets.npy'}", "-m", "5", "-s", "2", "--rotate",
        "-o", str(tmp_path / "out.npy"),
    )
    drawn = Sampler(sets, seed=2, rotate=True).random(5)
    of_file = Sampler(f"file:{tmp_path / 'sets.npy'}", seed=2, rotate=True)
    assert drawn.tobytes() == of_file.random(5).tobytes()
    assert drawn.tobytes() == np.load(tmp_path / "out.npy").tobytes()
    # One set, of any length, and changed afterwards.
    one = 3 * sets[0]
    with pytest.raises(ValueError, match="normalize"):
        Sampler(one)
    sampler = Sampler(one, normalize=True)
    one[:] = 0
    np.testing.assert_allclose(sampler.random()[0], sets[0], rtol=0, atol=4e-16)
    assert Sampler(sets[0].tolist()).random().shape == (1, 20, 3)
    weighted = Sampler((sets, np.arange(60.0).reshape(3, 20)))
    weighted.random()
    assert weighted.weights.shape == (3, 20)
    square = np.random.default_rng(0).random((30, 2))
    assert Sampler(square, square=True).random()[0].tobytes() == square.tobytes()


def test_sets_of_different_sizes_are_a_list() -> None:
    sampler = Sampler("poisson-disk:mode=saturated", 100)
    sets = sampler.random(12)
    assert isinstance(sets, list) and len({len(one) for one in sets}) > 1
    assert all(one.ndim == 2 and one.shape[1] == 3 for one in sets)
    sampler.reset()
    for one in sets:
        assert sampler.random(1)[0].tobytes() == one.tobytes()


def test_parameters() -> None:
    assert Sampler("step", 64, alpha=1).spec == "step:alpha=1"
    assert Sampler("profile:b=2", 64, alpha=1, to=2.0).spec == "profile:b=2,alpha=1,to=2.0"
    assert (
        Sampler("step", 64, alpha=1).random().tobytes()
        == Sampler("step:alpha=1", 64).random().tobytes()
    )
    assert repr(Sampler("step", 64, alpha=1, seed=3, rotate=True)) == (
        "Sampler('step:alpha=1', 64, seed=3, rotate=True)"
    )


def test_pickling_and_copies_continue() -> None:
    sets = Sampler("white-noise", 20, seed=1).random(3)
    for sampler in [
        Sampler("jittered", 48, seed=5, rotate=True),
        Sampler(sets, seed=1, rotate=True),
        Sampler((sets[0], np.arange(20.0))),
        Sampler("sobol", 16, square=True, shift=True),
    ]:
        sampler.random(2)
        twins = [pickle.loads(pickle.dumps(sampler)), copy.copy(sampler), copy.deepcopy(sampler)]
        expected = sampler.random(2)
        for twin in twins:
            assert twin.position == 2
            assert twin.random(2).tobytes() == expected.tobytes()
            assert repr(twin) == repr(sampler)


def test_errors() -> None:
    with pytest.raises(ValueError, match="fibonaci"):
        Sampler("fibonaci", 10)
    with pytest.raises(ValueError, match="nearest"):
        Sampler("healpix", 100)
    with pytest.raises(ValueError, match="number of points"):
        Sampler("fibonacci")
    with pytest.raises(ValueError, match="alpha"):
        Sampler("fibonacci", 10, alpha=1)
    with pytest.raises(OSError, match="missing"):
        Sampler("file:missing.csv")
    with pytest.raises(ValueError, match="shift"):
        Sampler("sobol", 16, square=True, rotate=True)
    with pytest.raises(ValueError, match="square"):
        Sampler("sobol", 16, shift=True)
    with pytest.raises(ValueError, match="seed must be from 0"):
        Sampler("fibonacci", 10, seed=-1)
    with pytest.raises(ValueError, match="n must be at least 1"):
        Sampler("fibonacci", 0)
    with pytest.raises(TypeError):
        Sampler("fibonacci", 10.5)
    with pytest.raises(TypeError, match="alpha: expected"):
        Sampler("step", 64, alpha=[1])
    sampler = Sampler("fibonacci", 10)
    with pytest.raises(ValueError, match="m must be at least 1"):
        sampler.random(0)
    with pytest.raises(ValueError, match="k must be"):
        sampler.fast_forward(-1)
    with pytest.raises(ValueError, match="numbered"):
        sampler.fast_forward(2**64 - 1).random(2)


def test_given_points_that_cannot_be() -> None:
    with pytest.raises(ValueError, match=r"points.*\(n, 3\)"):
        Sampler(np.zeros((4, 2)))
    with pytest.raises(ValueError, match=r"expected shape"):
        Sampler(np.zeros(3))
    with pytest.raises(ValueError):
        Sampler(np.zeros((0, 3)))
    bad = np.ones((5, 3))
    bad[3, 1] = np.nan
    with pytest.raises(ValueError, match=r"3"):
        Sampler(bad)
    with pytest.raises(ValueError):
        Sampler(np.zeros((5, 3)))
    with pytest.raises(ValueError, match=r"weights: expected shape \(5,\)"):
        Sampler((np.ones((5, 3)), np.ones(4)))
    with pytest.raises(TypeError):
        Sampler(np.array([["a", "b", "c"]]))
    with pytest.raises(ValueError, match="alpha"):
        Sampler(np.ones((5, 3)), alpha=1)


def test_memory_is_checked_before_it_is_taken() -> None:
    sampler = Sampler("white-noise", 1000)
    for m in [10**10, 10**15, 10**30]:
        with pytest.raises(MemoryError):
            sampler.random(m)
    assert sampler.position == 0
    for n in [10**13, 10**30]:
        with pytest.raises(MemoryError):
            Sampler("white-noise", n)


def test_progress_is_told() -> None:
    told: list[tuple[float, float]] = []
    sampler = Sampler("white-noise", 100_000)
    points = sampler.random(20, progress=lambda done, expected: told.append((done, expected)))
    assert points.shape == (20, 100_000, 3)
    assert told and told[-1][0] == pytest.approx(told[-1][1])
    assert sampler.reset().random(20, progress=True).tobytes() == points.tobytes()

    class Enough(Exception):
        pass

    def stop(done: float, expected: float) -> None:
        raise Enough

    with pytest.raises(Enough):
        Sampler("step", 4096).random(1000, progress=stop)


@pytest.mark.parametrize("format", ["quaternions", "matrices", "euler", "euler-degrees"])
def test_rotations_have_the_bytes_of_the_command(format: str, tmp_path: Path) -> None:
    path = tmp_path / "sets.npy"
    command(
        "rotations", "super-fibonacci", "-n", "30", "-m", "4", "-s", "3", "--rotate",
        "--format", format, "-o", str(path),
    )
    sets = sphvar.rotations("super-fibonacci", 30, 4, seed=3, rotate=True, format=format)
    assert sets.tobytes() == np.load(path).tobytes() and sets.shape == np.load(path).shape
    one = sphvar.rotations("super-fibonacci", 30, seed=3, rotate=True, format=format)
    assert one.tobytes() == sets[0].tobytes() and one.shape == sets.shape[1:]


def test_rotations_agree_with_scipy() -> None:
    rotation = pytest.importorskip("scipy.spatial.transform").Rotation
    make = lambda format: sphvar.rotations("uniform", 50, seed=1, format=format)  # noqa: E731
    expected = rotation.from_quat(np.roll(make("quaternions"), -1, axis=1))
    np.testing.assert_allclose(make("matrices"), expected.as_matrix(), atol=1e-14)
    of_angles = rotation.from_euler("ZYZ", make("euler"))
    np.testing.assert_allclose(of_angles.as_matrix(), expected.as_matrix(), atol=1e-14)
    sets, weights = sphvar.rotations("sukharev:weights=cell", 100, return_weights=True)
    assert sets.shape == (100, 4) and weights.shape == (100,)
    assert sphvar.rotations("uniform", 5, return_weights=True)[1] is None
    with pytest.raises(ValueError, match="format must be"):
        sphvar.rotations("uniform", 5, format="square")
    with pytest.raises(ValueError, match="rotations"):
        sphvar.rotations("fibonacci", 5)


def test_lists() -> None:
    for domain in ["sphere", "hemisphere", "square", "rotations"]:
        entries = sphvar.list_samplers(domain)
        assert entries and all(entry.name and entry.summary and entry.source for entry in entries)
        assert pickle.loads(pickle.dumps(entries)) == entries
    step = next(entry for entry in sphvar.list_samplers(n=100) if entry.name == "step")
    assert "alpha" in [parameter.name for parameter in step.parameters]
    assert [entry.name for entry in sphvar.list_integrands("square")]
    assert [entry.name for entry in sphvar.list_warps()]
    with pytest.raises(ValueError, match="domain must be"):
        sphvar.list_samplers("torus")
    with pytest.raises(AttributeError, match="has no 'colour'"):
        step.colour


def test_short_calls_start_no_threads() -> None:
    """A forked process has no threads of its parent, so what runs in the calling thread needs none."""
    if sys.platform != "linux":
        pytest.skip("reads /proc")
    code = """
import os, sphvar
count = lambda: len(os.listdir("/proc/self/task"))
before = count()
names = [entry.name for entry in sphvar.list_samplers()]
started = count()
for name in names:
    for n in [1, 2, 4, 12, 48]:
        try:
            sphvar.Sampler(name, n, nearest=True).random(1)
        except (ValueError, OSError, RuntimeError):
            # A file is missing, or few points do not suffice.
            continue
# The pool of the package, and none of rayon's own.
assert count() == started <= before + os.cpu_count(), (before, started, count())
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=120)


def _draw(seed: int) -> bytes:
    sampler = Sampler("poisson-disk", 100, seed=seed)
    return bytes(sampler.random(30).tobytes())


def test_forked_processes_draw() -> None:
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("no fork")
    expected = [_draw(seed) for seed in range(4)]
    with multiprocessing.get_context("fork").Pool(2) as pool:
        assert pool.map_async(_draw, range(4)).get(timeout=60) == expected
    assert _draw(0) == expected[0]


def test_samplers_are_equal_if_they_draw_the_same():
    one = Sampler("jittered", 48, seed=1)
    assert one == Sampler("jittered", 48, seed=1) == pickle.loads(pickle.dumps(one))
    assert one != Sampler("jittered", 48)
    assert one != Sampler("jittered", 48, seed=1, rotate=True)
    assert one != Sampler("jittered", 48, seed=1).fast_forward(1)
    points = one.random()
    assert Sampler(points) == Sampler(points.copy()) != Sampler(-points)
    assert Sampler(points) != one


def test_lists_and_entries_print_their_parameters() -> None:
    warps = sphvar.list_warps()
    assert len(repr(warps).splitlines()) == len(warps)
    assert "kappa" in repr(warps)
    sobol = next(entry for entry in sphvar.list_samplers() if entry.name == "sobol")
    assert "default owen" in str(sobol)
    assert all(part.name in sobol._repr_html_() for part in sobol.parameters)
    assert warps._repr_html_().count("<tr>") == len(warps) + 1
    assert sphvar.Sampler('sobol:warp="vmf:kappa=20"', 8).random(1).shape == (1, 8, 3)
