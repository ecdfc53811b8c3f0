"""`spectrum`: against the definition and the command, merged, stored, and at the edges."""

import _thread
import copy
import functools
import itertools
import operator
import pathlib
import pickle
import threading
import time

import numpy as np
import pytest
from commands import document
from hypothesis import given, settings
from hypothesis import strategies as st

import sphvar

DATA = pathlib.Path(__file__).parents[2] / "data"


def random_sets(m, n, seed=0):
    points = np.random.default_rng(seed).normal(size=(m, n, 3))
    return points / np.linalg.norm(points, axis=2)[:, :, np.newaxis]


def powers(points, lmax, weights=None):
    """The power of a set by the addition theorem: sums of Legendre polynomials over pairs."""
    w = np.ones(len(points)) if weights is None else np.asarray(weights)
    pairs = np.outer(w, w)
    cosines = np.clip(points @ points.T, -1, 1)
    legendre = [np.polynomial.legendre.Legendre.basis(l)(cosines) for l in range(lmax + 1)]
    return np.array([(pairs * p).sum() for p in legendre]) / (w**2).sum()


def same(spectrum, of_command):
    """Whether a spectrum has the bits of a document of the command."""
    ours = spectrum.to_dict()
    kept = lambda d: {k: v for k, v in d.items() if k not in ("seconds", "provenance", "sampler")}
    assert kept(ours) == kept(of_command)
    assert ours["provenance"]["seed"] == of_command["provenance"]["seed"]


def test_power_is_that_of_the_definition():
    sets = random_sets(5, 40)
    spectrum = sphvar.spectrum(sets, lmax=12)
    each = np.array([powers(points, 12) for points in sets])
    assert np.allclose(spectrum.power, each.mean(axis=0), rtol=1e-11)
    assert np.allclose(spectrum.stderr[1:], each.std(axis=0, ddof=1)[1:] / np.sqrt(5), rtol=1e-9)
    assert spectrum.l.tolist() == list(range(13))
    assert (spectrum.n, spectrum.lmax, spectrum.realizations) == (40, 12, 5)
    assert spectrum.n_effective == 40
    assert np.array_equal(spectrum.omega, spectrum.l / np.sqrt(40))


def test_weights_count():
    points = random_sets(1, 30)[0]
    weights = np.random.default_rng(1).uniform(-0.2, 1, size=30)
    spectrum = sphvar.spectrum(points, lmax=6, weights=weights)
    assert np.allclose(spectrum.power, powers(points, 6, weights), rtol=1e-11)
    assert spectrum.n_effective == pytest.approx(weights.sum() ** 2 / (weights**2).sum())
    assert sphvar.spectrum((points, weights), lmax=6) == spectrum
    assert np.isnan(spectrum.stderr).all()


def test_hemisphere_has_even_degrees():
    points = random_sets(1, 30)[0]
    spectrum = sphvar.spectrum(points, lmax=6, hemisphere=True)
    assert spectrum.l.tolist() == [0, 2, 4, 6]
    assert np.allclose(spectrum.power, powers(points, 6)[::2], rtol=1e-11)
    assert spectrum.domain == "hemisphere"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (dict(source="jittered", n=48, realizations=7), "jittered -n 48 -m 7"),
        (dict(source="jittered", n=48, lmax=9, seed=5), "jittered -n 48 --lmax 9 --seed 5"),
        (dict(source="jittered", n=48, exact=True), "jittered -n 48 --exact"),
        (dict(source="fibonacci", n=50, hemisphere=True), "fibonacci -n 50 --hemisphere"),
        (dict(source="healpix", n=50, nearest=True), "healpix -n 50 --nearest"),
        (
            dict(source="poisson-disk", n=30, realizations=3, pairs=True, max_angle=20, bins=5),
            "poisson-disk -n 30 -m 3 --pairs --max-angle 20 --bins 5",
        ),
        (
            dict(source="white-noise", n=3000, realizations=2, method="fast", epsilon=1e-5),
            "white-noise -n 3000 -m 2 --method fast --epsilon 1e-5",
        ),
        (
            dict(source=DATA / "stars.csv", columns="ra,dec,_", lmax=8),
            f"--points {DATA / 'stars.csv'} --columns ra,dec,_ --lmax 8",
        ),
        (
            dict(source="jittered-square", n=64, square=True, realizations=4, kmax=8),
            "jittered-square -n 64 --square -m 4 --kmax 8",
        ),
        (
            dict(source="jittered-square", n=64, square=True, exact=True),
            "jittered-square -n 64 --square --exact",
        ),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_the_command_has_the_same_bits(arguments, words):
    same(sphvar.spectrum(**arguments), document("spectrum", *words.split()))


def test_arrays_have_the_bits_of_files(tmp_path):
    sets = random_sets(3, 20)
    np.save(tmp_path / "sets.npy", sets)
    expected = document("spectrum", "--points", str(tmp_path / "sets.npy"), "--lmax", "9")
    same(sphvar.spectrum(sets, lmax=9), expected)
    same(sphvar.spectrum(tmp_path / "sets.npy", lmax=9), expected)
    points = np.random.default_rng(0).random((20, 2))
    np.save(tmp_path / "square.npy", points)
    words = ["--square", "--points", str(tmp_path / "square.npy"), "--kmax", "5"]
    same(sphvar.spectrum(points, square=True, kmax=5), document("spectrum", *words))


def test_the_square_is_that_of_the_definition():
    points = np.random.default_rng(2).random((25, 2))
    spectrum = sphvar.spectrum(points, square=True, kmax=6)
    sums = np.exp(-2j * np.pi * spectrum.k @ points.T).sum(axis=1)
    assert np.allclose(spectrum.power, np.abs(sums) ** 2 / 25, rtol=1e-10)
    assert np.isnan(spectrum.stderr).all()
    ring = [np.rint(np.hypot(*spectrum.k.T)) == r for r in spectrum.radius]
    assert np.allclose(spectrum.radial_power, [spectrum.power[r].mean() for r in ring])
    assert (spectrum.kmax, spectrum.n, spectrum.domain) == (6, 25, "square")


@pytest.mark.parametrize("options", [{}, dict(hemisphere=True), dict(square=True)])
def test_parts_merge_in_any_order_to_the_bits_of_one_run(options):
    # The jittered pattern of the hemisphere has other numbers of points.
    names = {"square": "white-square", "hemisphere": "white-noise"}
    source = next((names[key] for key in options), "jittered")
    arguments = dict(realizations=10, seed=3) | options
    whole = sphvar.spectrum(source, 48, **arguments)
    parts = [sphvar.spectrum(source, 48, shard=(i, 3), **arguments) for i in (1, 2, 3)]
    for order in itertools.permutations(parts):
        merged = functools.reduce(operator.add, order)
        assert merged == whole
        assert np.array_equal(merged.power, whole.power)
        assert np.array_equal(merged.stderr, whole.stderr)
    assert sum(parts) == whole
    with pytest.raises(ValueError, match="realization 0 is in the spectrum and in the other"):
        whole.merge(parts[0])


@given(st.integers(0, 2**32), st.integers(1, 6), st.booleans())
@settings(deadline=None, max_examples=25)
def test_given_sets_merge_to_the_bits_of_all(seed, split, weighted):
    sets = random_sets(7, 10, seed)
    weights = np.random.default_rng(seed).random((7, 10)) + 0.1 if weighted else None
    part = lambda a, i: None if a is None else a[i]
    whole = sphvar.spectrum(sets, lmax=5, weights=weights)
    first, second = (
        sphvar.spectrum(sets[i], lmax=5, weights=part(weights, i))
        for i in (slice(split), slice(split, None))
    )
    for merged in (first + second, second + first):
        assert merged == whole
        assert merged.realizations == 7
    assert first.n_effective == pytest.approx(whole.n_effective, rel=1)


def test_spectra_of_different_kinds_do_not_merge():
    white = sphvar.spectrum("white-noise", 12, lmax=4, realizations=2)
    for other, kind, message in [
        (sphvar.spectrum("white-noise", 12, lmax=4, realizations=2, seed=1), ValueError, "seeds"),
        (sphvar.spectrum("jittered", 12, lmax=4, realizations=2), ValueError, "samplers"),
        (sphvar.spectrum("jittered", 12, lmax=4, exact=True), ValueError, "closed form"),
        (sphvar.spectrum(random_sets(2, 12), lmax=4), ValueError, "a sampler and of given sets"),
        (sphvar.spectrum("halton", 12, square=True, kmax=4, realizations=2), TypeError, "domain"),
    ]:
        with pytest.raises(kind, match=message):
            white.merge(other)
    with pytest.raises(TypeError):
        white + 1
    with pytest.raises(ValueError, match="different numbers of points"):
        sphvar.spectrum(random_sets(1, 9), lmax=4) + sphvar.spectrum(random_sets(1, 8), lmax=4)


def test_spectra_are_stored_and_copied():
    for spectrum in [
        sphvar.spectrum("jittered", 12, lmax=4, realizations=3, shard=(1, 2)),
        sphvar.spectrum("jittered", 12, lmax=4, exact=True),
        sphvar.spectrum("halton", 12, square=True, kmax=4, realizations=2),
        sphvar.spectrum(random_sets(2, 9), lmax=3),
    ]:
        for stored in [pickle.loads(pickle.dumps(spectrum)), copy.deepcopy(spectrum)]:
            assert stored == spectrum
            assert type(stored) is type(spectrum)
            assert stored.to_dict() == spectrum.to_dict()
    half = sphvar.spectrum("jittered", 12, lmax=4, realizations=3, shard=(2, 2))
    first = pickle.loads(
        pickle.dumps(sphvar.spectrum("jittered", 12, lmax=4, realizations=3, shard=(1, 2)))
    )
    assert first + half == sphvar.spectrum("jittered", 12, lmax=4, realizations=3)


def test_one_point_and_degree_zero():
    spectrum = sphvar.spectrum([[0, 0, 1.0]], lmax=0)
    assert spectrum.power.tolist() == [pytest.approx(1)]
    assert sphvar.spectrum("white-noise", 1, lmax=0, realizations=1).power == pytest.approx([1])
    repeated = sphvar.spectrum([[0, 0, 1.0]] * 4, lmax=3)
    assert np.allclose(repeated.power, 4)


def test_the_sampler_object_has_its_own_options():
    sampler = sphvar.Sampler("white-noise", 48, seed=4, hemisphere=True)
    expected = sphvar.spectrum("white-noise", 48, seed=4, hemisphere=True, realizations=3)
    assert sphvar.spectrum(sampler, realizations=3) == expected
    square = sphvar.Sampler("white-square", 16, square=True)
    assert sphvar.spectrum(square, kmax=4, realizations=3).domain == "square"
    points = random_sets(2, 9)
    weights = np.arange(18.0).reshape(2, 9)
    for given in [points, (points, weights)]:
        assert sphvar.spectrum(sphvar.Sampler(given), lmax=4) == sphvar.spectrum(given, lmax=4)
    assert sphvar.spectrum("healpix", 100, nearest=True, lmax=4) == sphvar.spectrum(
        sphvar.Sampler("healpix", 100, nearest=True), lmax=4
    )


@pytest.mark.parametrize(
    ("arguments", "kind", "message"),
    [
        (dict(source="jitterd", n=9), ValueError, "jitterd"),
        (dict(source="jittered"), ValueError, "option n,"),
        (dict(source="jittered", n=-1), ValueError, "-1"),
        (dict(source="healpix", n=50), ValueError, "nearest"),
        (dict(source="jittered", n=12, realizations=0), ValueError, "at least 1, got 0"),
        (dict(source="jittered", n=12, lmax=-1), ValueError, "-1"),
        (dict(source="jittered", n=12, lmax=1000001), ValueError, "1000000"),
        (dict(source="jittered", n=12, lmax=1000000), MemoryError, "requires"),
        (dict(source="jittered", n=12, shard=(3, 2)), ValueError, "shard: expected"),
        (dict(source="jittered", n=12, shard=2), TypeError, "shard: expected two integers"),
        (dict(source="jittered", n=12, exact=True, shard=(1, 2)), ValueError, "no parts"),
        (dict(source="poisson-disk", n=9, exact=True), ValueError, "no closed form"),
        (dict(source="jittered", n=12, epsilon=2.0), ValueError, "epsilon must be in"),
        (dict(source="jittered", n=12, weights=[1.0] * 9), ValueError, "not for the sampler"),
        (dict(source="jittered", n=12, realisations=3), TypeError, "realizations"),
        (dict(source=pathlib.Path("missing.csv")), OSError, "missing.csv"),
        (dict(source=np.zeros((4, 2))), ValueError, "expected shape"),
        (dict(source=np.full((4, 3), np.nan)), ValueError, "points"),
        (dict(source=np.zeros((0, 3))), ValueError, "points"),
        (dict(source=[[0, 0, 1.0]], weights=[1.0, 2]), ValueError, "weights"),
        (dict(source=[[0, 0, 1.0]], weights=[1j]), TypeError, "weights"),
        (dict(source=[[0, 0, 1.0]], weights=[0.0]), ValueError, "0"),
        (dict(source=[[0, 0, 1.0]], realizations=3), ValueError, "realizations"),
        (dict(source=[[0, 0, 1.0]], columns="x,y,z"), ValueError, "columns"),
        (dict(source=[[0, 0, 1.0]], shard=(1, 2)), ValueError, "no parts"),
    ],
    ids=str,
)
def test_invalid_arguments_are_named(arguments, kind, message):
    with pytest.raises(kind, match=message):
        sphvar.spectrum(**arguments)


def test_an_array_hides_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    np.save("points", random_sets(1, 5)[0])
    by_file = sphvar.spectrum(pathlib.Path("points.npy"), lmax=3)
    assert sphvar.spectrum(random_sets(1, 6)[0], lmax=3).n == 6
    assert by_file.n == 5
    (tmp_path / "points.npy").rename(tmp_path / "-points.npy")
    renamed = sphvar.spectrum(pathlib.Path("-points.npy"), lmax=3)
    assert np.array_equal(renamed.power, by_file.power)


def test_two_threads_have_the_results_of_one():
    expected = sphvar.spectrum("poisson-disk", 60, realizations=20)
    results = [None, None]

    def work(i):
        results[i] = sphvar.spectrum("poisson-disk", 60, realizations=20)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [expected, expected]


def test_progress_stops():
    def stop(done, expected):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        sphvar.spectrum("ccvt", 500, realizations=100, progress=stop)


def test_plots():
    pyplot = pytest.importorskip("matplotlib.pyplot")
    axes = sphvar.spectrum("jittered", 48, realizations=5).plot()
    assert axes.get_ylabel() == "power P(l)"
    axes = sphvar.spectrum("halton", 48, square=True, realizations=5).plot()
    assert "|k|" in axes.get_xlabel()
    pyplot.close("all")


def test_an_interrupt_stops_one_long_realization():
    timer = threading.Timer(0.3, _thread.interrupt_main)
    timer.start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        sphvar.spectrum("ccvt", 20000, realizations=2)
    # A second after the interrupt, and what a busy machine adds.
    assert time.monotonic() - start < 0.3 + 1 + 2


def test_any_number_of_spectra_merge():
    parts = [sphvar.spectrum("jittered", 48, realizations=6, shard=(i, 3)) for i in (1, 2, 3)]
    whole = sphvar.spectrum("jittered", 48, realizations=6)
    assert parts[2].merge(*parts[:2]) == sphvar.Spectrum.merge(*parts) == whole
    assert whole.merge() == whole
    with pytest.raises(TypeError, match="expected spectra of the same domain, got Spectrum and list"):
        parts[0].merge(parts)


def test_pairs_of_angles_are_rejected_with_advice():
    for call in (sphvar.spectrum, sphvar.quality, sphvar.weights):
        with pytest.raises(ValueError, match=r"got \(5, 2\); sphvar.healpix.ang2vec makes vectors"):
            call(np.zeros((5, 2)))
