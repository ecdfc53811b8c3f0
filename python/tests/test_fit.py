"""`weights` and `fit`: against the command, numpy and their definitions, and at the edges."""

import pathlib
import pickle

import numpy as np
import pytest
from commands import document

import sphvar

DATA = pathlib.Path(__file__).parents[2] / "data"


def random_points(n, seed=0):
    points = np.random.default_rng(seed).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1)[:, np.newaxis]


def without_run(document):
    return {k: v for k, v in document.items() if k not in ("provenance", "points")}


@pytest.mark.parametrize(
    "options", [dict(degree=5), dict(), dict(degree=3, nonnegative=True), dict(hemisphere=True)]
)
def test_weights_are_those_of_the_command(options, tmp_path):
    points = random_points(80)
    np.save(tmp_path / "points.npy", points)
    flags = [
        word
        for key, value in options.items()
        for word in ([f"--{key}"] if value is True else [f"--{key}", str(value)])
    ]
    expected = document("weights", str(tmp_path / "points.npy"), *flags)
    for source in (points, tmp_path / "points.npy"):
        weights = sphvar.weights(source, **options)
        assert without_run(weights.to_dict()) == without_run(expected)
        assert weights.weights.tolist() == expected["weights"]


def test_weights_integrate_harmonics():
    points = random_points(100)
    weights = sphvar.weights(points, degree=6)
    sums = sphvar.points2alm(points, 6, weights=weights)
    assert np.abs(sums[1:]).max() < 1e-10
    assert sums[0] == pytest.approx(np.sqrt(4 * np.pi))
    assert weights.degree <= weights.exact_degree
    assert len(weights) == weights.n == 100
    assert np.sum(weights) == pytest.approx(4 * np.pi)
    assert np.asarray(weights, dtype=np.float32).dtype == np.float32
    assert sphvar.weights(points, degree=3, nonnegative=True).weights.min() >= 0


def test_fit_is_that_of_the_command(tmp_path):
    points = random_points(90)
    values = 1 + points[:, 0] * points[:, 1]
    weights = np.random.default_rng(1).uniform(0.5, 2, size=90)
    for name, column in [("w", dict(weights=weights)), ("sigma", dict(sigma=weights)), ("", {})]:
        table = np.column_stack([points, values, *column.values()])
        header = ",".join(["x,y,z,value", *([name] if name else [])])
        path = tmp_path / f"values{name}.csv"
        np.savetxt(path, table, "%.17g", ",", header=header, comments="")
        expected = document("fit", str(path), "--lmax", "4", "--ridge", "0.25")
        fit = sphvar.fit(points, values, 4, ridge=0.25, **column)
        assert without_run(fit.to_dict()) == without_run(expected)
        assert sphvar.fit(path, None, 4, ridge=0.25).alm.tolist() == fit.alm.tolist()


def test_fit_is_the_least_squares_solution():
    points = random_points(120)
    rng = np.random.default_rng(2)
    values, weights = rng.normal(size=120), rng.uniform(0.1, 3, size=120)
    fit = sphvar.fit(points, values, 4, weights=weights)
    # Real harmonics from unit coefficients: a real and, for m > 0, an imaginary part of each.
    rows = []
    for k in range(15):
        for unit in [1, 1j] if k > 4 else [1]:
            alm = np.zeros(15, dtype=complex)
            alm[k] = unit
            rows.append(sphvar.alm2points(alm, points))
    matrix = np.array(rows).T
    root = np.sqrt(weights)
    solution = np.linalg.lstsq(matrix * root[:, np.newaxis], values * root, rcond=None)[0]
    assert np.allclose(fit.eval(points), matrix @ solution, rtol=1e-9, atol=1e-9)
    residuals = values - fit.eval(points)
    rms = np.sqrt((weights * residuals**2).sum() / weights.sum())
    assert fit.residual_rms == pytest.approx(rms, rel=1e-9)
    assert fit.noise_variance == pytest.approx((weights * residuals**2).sum() / (120 - 25))
    twice = np.where(np.arange(15) < 5, 1, 2)
    degrees = np.array([l for m in range(5) for l in range(m, 5)])
    fitted = np.bincount(degrees, twice * np.abs(fit.alm) ** 2)
    assert np.allclose(fit.energies + fit.noise_energies, fitted)
    assert (fit.energies_stderr > 0).all()


def test_exact_values_are_reproduced():
    points = random_points(60)
    fit = sphvar.fit(points, points[:, 2] ** 2, 3)
    assert fit.residual_rms < 1e-10
    others = random_points(7, seed=5).reshape(7, 1, 3)
    assert np.allclose(fit.eval(others), others[..., 2] ** 2)
    assert fit.energies[0] == pytest.approx(4 * np.pi / 9)
    catalogue = sphvar.fit(DATA / "stars.csv", None, 4, columns="ra=ra,dec=dec,value=magnitude")
    assert catalogue.n > 1000


def test_results_are_stored():
    points = random_points(30)
    for result in [sphvar.weights(points, degree=2), sphvar.fit(points, points[:, 0], 2)]:
        stored = pickle.loads(pickle.dumps(result))
        assert stored == result
        assert repr(stored) == repr(result)


@pytest.mark.parametrize(
    ("call", "kind", "message"),
    [
        (lambda p: sphvar.weights(p, degree=9), ValueError, "degree 9 need 100 distinct points"),
        (lambda p: sphvar.weights(p, degree=-1), ValueError, "-1"),
        (lambda p: sphvar.weights("points.csv"), TypeError, "pathlib.Path"),
        (lambda p: sphvar.weights([p, p]), ValueError, "got 2 sets"),
        (lambda p: sphvar.weights(p, degre=2), TypeError, "degree"),
        (lambda p: sphvar.weights(p[:, :2]), ValueError, "expected shape"),
        (lambda p: sphvar.fit(p, p[:, 0], 9), ValueError, "distinct points"),
        (lambda p: sphvar.fit(p, p[:-1, 0], 2), ValueError, "values"),
        (lambda p: sphvar.fit(p, p[:, 0] * np.nan, 2), ValueError, "value"),
        (lambda p: sphvar.fit(p, p[:, 0], 2, weights=-np.ones(20)), (ValueError, RuntimeError), "weight|w"),
        (lambda p: sphvar.fit(p, p[:, 0], 2, weights=p[:, 0] * 1j), TypeError, "weights"),
        (lambda p: sphvar.fit(p, p[:, 0], 2, ridge=-1), ValueError, "ridge"),
        (lambda p: sphvar.fit(p, None, 2), ValueError, "value"),
        (
            lambda p: sphvar.fit(p, p[:, 0], 2, weights=np.ones(20), sigma=np.ones(20)),
            ValueError,
            "sigma",
        ),
        (lambda p: sphvar.fit(pathlib.Path("no.csv"), None, 2), OSError, "no.csv"),
        (lambda p: sphvar.fit(pathlib.Path("no.csv"), p[:, 0], 2), ValueError, "values"),
    ],
)
def test_invalid_arguments_are_named(call, kind, message):
    with pytest.raises(kind, match=message):
        call(random_points(20))


def test_plots():
    pyplot = pytest.importorskip("matplotlib.pyplot")
    points = random_points(60)
    axes = sphvar.fit(points, points[:, 0], 3).plot()
    assert axes.get_xlabel() == "degree l"
    pyplot.close("all")
