"""Results: attributes, columns, tables, equality, pickling, plots."""

import copy
import json
import pathlib
import pickle
import sys

import numpy as np
import pytest

import sphvar
from sphvar import _plots, _results

SCHEMA = json.loads(
    (pathlib.Path(__file__).parents[2] / "docs" / "schema.json").read_text(encoding="utf-8")
)

# The document and the record of the rows of every class.
KINDS = {
    "VarianceResult": ("variance", "RowRecord"),
    "ComparisonResult": ("compare", "RowRecord"),
    "ChoiceResult": ("choose", "CandidateRecord"),
    "ProgressiveResult": ("progressive", "PrefixRecord"),
    "BoundsResult": ("bounds", "BoundRecord"),
    "AuditResult": ("audit", "AuditRecord"),
    "QualityResult": ("quality", "QualityRecord"),
    "LightsResult": ("lights", "ErrorRow"),
    "RotationQualityResult": ("rotations", "MeasuresRecord"),
}


@pytest.fixture(scope="module")
def results():
    """One result of every class."""
    names = ["white-noise", "fibonacci"]
    cap = "cap:degrees=60"
    return [
        sphvar.variance(names, n=[12, 48], integrand=cap, realizations=100),
        sphvar.compare(names, n=[12, 48, 192], integrand=cap, realizations=100),
        sphvar.choose(names, integrand=cap, n=48),
        sphvar.progressive(["sobol"], n=[4, 8, 16], integrand=cap, realizations=50),
        sphvar.bounds("jittered", n=48),
        sphvar.audit("jittered", n=12, realizations=60, lmax=3),
        sphvar.quality(names, n=48),
        sphvar.lights(np.ones((8, 16, 3)), n=6, realizations=2),
        sphvar.rotation_quality(["super-fibonacci"], n=[8, 16]),
    ]


def test_there_is_a_result_of_every_class(results):
    assert {type(result).__name__ for result in results} == set(KINDS)


@pytest.mark.parametrize("name", KINDS)
def test_attributes_are_those_of_the_schema(name):
    kind = getattr(_results, name)
    document, record = KINDS[name]
    keys = {*SCHEMA["documents"][document]["properties"], *SCHEMA["$defs"][record]["properties"]}
    if name == "QualityResult":
        keys |= set(SCHEMA["$defs"]["SquareQualityRecord"]["properties"])
    annotated = {key for base in kind.__mro__ for key in getattr(base, "__annotations__", {})}
    annotated = {key for key in annotated if not key.startswith("_")}
    assert annotated <= keys
    # Rows have their own property; the others are given for special questions only.
    special = {
        "rows", "bounds", "audits", "irradiance_errors", "visible_half", "n_effective", "predicted",
        "predicted_stderr", "predicted_tail_error", "coefficients",
    }  # fmt: skip
    required = {*SCHEMA["documents"][document]["required"], *SCHEMA["$defs"][record]["required"]}
    assert required - special <= annotated
    own = [base for base in kind.__mro__ if base.__module__ == kind.__module__]
    described = " ".join(base.__doc__ or "" for base in own)
    assert not [key for key in annotated if key not in described]


def test_attributes_are_columns_or_keys(results):
    for result in results:
        document = result.to_dict()
        for key in document:
            assert hasattr(result, key)
        for key in result.columns:
            assert hasattr(result, key)
        if not isinstance(result, sphvar.QualityResult):
            assert len(result.column(result.columns[0])) == len(result) == len(list(result))
        assert set(dir(result)) >= {*document, *result.columns}


def test_columns_have_numbers(results):
    variances = results[0]
    assert variances.n.tolist() == [12, 48, 12, 48]
    assert variances.n.dtype == np.int64
    assert variances.sampler.dtype.kind == "U"
    assert variances.predicted.dtype == np.float64
    assert np.isnan(variances.n_effective).all()
    assert np.array_equal(variances.predicted, [row["predicted"] for row in variances])
    assert results[8].power.shape == (2, 5)
    assert np.isnan(results[8].power_stderr).any()


@pytest.mark.parametrize(
    ("entries", "dtype"),
    [
        ([1, 2], "i"),
        ([1, None], "f"),
        ([1.5, 2], "f"),
        ([None, None], "f"),
        ([], "f"),
        (["a", "b"], "U"),
        (["a", None], "O"),
        ([True, False], "b"),
        ([True, None], "O"),
        ([[1, 2], [3, None]], "f"),
        ([[1, 2], None], "f"),
        ([[1, 2], [3]], "O"),
        ([{"a": 1}, None], "O"),
    ],
)
def test_kinds_of_columns(entries, dtype):
    array = _results._array(entries)
    assert array.dtype.kind == dtype
    assert len(array) == len(entries)


def test_results_are_pickled_copied_and_compared(results):
    for result in results:
        assert pickle.loads(pickle.dumps(result)) == result
        assert copy.deepcopy(result) == result
        assert result != results[results[0] is result]
        other = result.to_dict()
        other["provenance"] = None
        assert type(result)(other) == result
        other["more"] = 1
        assert type(result)(other) != result
        with pytest.raises(TypeError):
            hash(result)


def test_documents_are_copies(results):
    document = results[0].to_dict()
    document["rows"][0]["n"] = -1
    assert results[0].n[0] == 12
    assert json.loads(json.dumps(results[0].to_dict())) == results[0].to_dict()


def test_tables(results):
    for result in results:
        text, page = repr(result), result._repr_html_()
        lines = text.splitlines()
        assert len(lines) > min(len(result), 20)
        assert all(line == line.rstrip() for line in lines)
        assert page.count("<tr>") >= 2 and page.count("<td>") == page.count("</td>")
    header, *rows = repr(results[0]).splitlines()
    assert header.split()[:3] == ["sampler", "N", "predicted"]
    assert len({len(row) for row in rows}) == 1


def test_long_tables_are_cut():
    rows = [{"a": i, "b": None, "c": "<x>"} for i in range(30)]
    table = _results.Table({"rows": rows})
    lines = repr(table).splitlines()
    assert lines[0].split() == ["a", "c"]
    assert lines[-1] == "and 10 more rows"
    assert len(lines) == 22
    assert "&lt;x&gt;" in table._repr_html_()
    assert repr(_results.Table({"rows": []})) == "Table without rows"


def test_sequences(results):
    table = results[0]
    assert table[0] is table.rows[0]
    assert table[-1]["n"] == 48
    assert table[1:3] == table.rows[1:3]
    assert len(table) == 4
    with pytest.raises(IndexError):
        table[4]


def test_best(results):
    variances, comparison, choice, progressive = results[:4]
    assert (variances.best["sampler"], variances.best["n"]) == ("fibonacci", 48)
    assert (comparison.best["sampler"], comparison.best["n"]) == ("fibonacci", 192)
    assert choice.best["sampler"] == "fibonacci"
    assert progressive.best["sampler"] == "sobol"


def test_missing_attributes_name_the_close_ones(results):
    with pytest.raises(AttributeError, match="did you mean predicted"):
        _ = results[0].predictd
    with pytest.raises(KeyError):
        results[0].column("predictd")


def test_one_sampler_has_numbers_and_several_arrays():
    one = sphvar.quality("fibonacci", n=48)
    several = sphvar.quality(["fibonacci", "healpix"], n=48)
    assert isinstance(one.separation, float)
    assert several.separation.shape == (2,)
    assert several.separation[0] == one.separation
    assert several.worst_case_error[1.5][0] == one.worst_case_error[1.5]
    assert list(one.riesz_energy) == [0, 1, 2]


def test_plots(results):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    for result in results:
        ax = result.plot()
        assert ax.get_xlabel() or len(ax.get_xticklabels()) > 1
        assert ax.get_ylabel()
        assert ax.lines or ax.collections
        figure, given = pyplot.subplots()
        assert result.plot(given) is given
        figure.canvas.draw()
        pyplot.close("all")
    assert results[0].plot(standard_errors=True).get_ylabel() == "standard error"
    assert results[3].plot(factors=True).get_ylabel() == "standard error / fibonacci"
    spectrum = sphvar.spectrum("jittered", n=48, realizations=20)
    assert len(results[4].plot(spectrum=spectrum).lines) > len(results[4])
    several = sphvar.lights(np.ones((8, 16, 3)), n=[2, 4], realizations=2)
    assert several.plot().get_xlabel() == "number of lights N"
    pyplot.close("all")


def test_plots_show_the_numbers(results):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    lines = results[0].plot().get_lines()
    for sampler in ("white-noise", "fibonacci"):
        rows = [row for row in results[0] if row["sampler"] == sampler]
        predicted = [row["predicted"] for row in rows]
        assert any(np.array_equal(line.get_ydata(), predicted) for line in lines)
        measured = [row["measured"] for row in rows]
        assert any(np.array_equal(line.get_ydata(), measured) for line in lines)
    pyplot.close("all")


def test_plots_without_matplotlib(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(ImportError, match=r"pip install sphvar\[plot\]"):
        _plots.axes(None)
    with pytest.raises(ImportError, match=r"pip install sphvar\[plot\]"):
        results[0].plot()


def test_pandas(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install pandas"):
        results[0].to_pandas()


def test_values_show_the_digits_that_errors_justify():
    assert _results._text(1.5707868123, 1.202e-6) == "1.5707868"
    assert _results._text(1.5707868123, 0.5) == "1.571"
    assert _results._text(123456.0, 3.0) == "123456"
    assert _results._text(1.5, 1e-300) == "1.5"
    for error in (None, 0.0, np.nan, np.inf, 9.0):
        assert _results._text(1.5707868123, error) == "1.571"
    integral = sphvar.integrate("cap:degrees=60 + vmf:kappa=3", rtol=1e-4)
    shown = float(str(integral).split("value")[1].split()[0])
    assert abs(shown - integral.value) < integral.error / 10


def test_what_is_left_out_of_a_choice_is_shown():
    points = sphvar.Sampler("jittered", 192).random()[0]
    choice = sphvar.choose({"mine": points, "sobol": "sobol"}, n=128, integrand="cap:degrees=60")
    for text in (repr(choice), choice._repr_html_()):
        assert "Left out: mine (its minimum number of points, 192, exceeds" in text


def test_the_best_choice_is_the_recommended_one():
    image = np.exp(np.random.default_rng(1).normal(size=(8, 16)))
    choice = sphvar.choose(["white-noise", "fibonacci", "sobol"], n=64, integrand=image)
    start = f"Recommended: {choice.best['sampler']} with N = {choice.best['n']} "
    assert choice.recommendation.startswith(start)
    assert choice.rows[0]["rank"] == 1


def test_columns_are_items():
    table = sphvar.quality(["fibonacci", "healpix"], n=48)
    assert table["n"].tolist() == [48, 48]
    with pytest.raises(KeyError, match="nothing"):
        table["nothing"]


def test_remarks_are_shown():
    row = {"sampler": "a", "n": 4, "measured": 1.0, "remark": "too few trials"}
    table = sphvar.VarianceResult({"rows": [row, {**row, "n": 8}, {**row, "remark": None}]})
    assert repr(table).endswith("a N = 4, a N = 8: too few trials")
