"""Plots: colours on shared axes, legends, orientation of lights, pair correlations."""

import numpy as np
import pytest

import sphvar
from sphvar._results import ChoiceResult

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")


@pytest.fixture(autouse=True)
def closed_figures():
    yield
    from matplotlib import pyplot

    pyplot.close("all")


def labelled(axes):
    return {line.get_label(): line for line in axes.lines if not line.get_label().startswith("_")}


def test_results_on_the_same_axes_differ_in_colour():
    axes = sphvar.spectrum("jittered", 48).plot()
    assert sphvar.spectrum("white-noise", 48).plot(ax=axes) is axes
    colours = {line.get_color() for line in labelled(axes).values()}
    assert set(labelled(axes)) == {"jittered", "white-noise"}
    assert len(colours) == 2


def test_given_axes_keep_their_own_colours():
    from matplotlib import pyplot

    axes = pyplot.figure().subplots()
    axes.set_prop_cycle(color=["red", "lime"])
    axes.plot([1, 2], [1, 2])
    sphvar.spectrum("jittered", 48).plot(ax=axes)
    assert labelled(axes)["jittered"].get_color() == "lime"


def test_long_legends_are_beside_new_axes():
    axes = sphvar.bounds("jittered", n=48).plot()
    axes.figure.draw_without_rendering()
    legend = axes.get_legend()
    assert len(legend.get_texts()) > 4
    assert legend.get_window_extent().x0 >= axes.get_window_extent().x1


def test_pair_correlations_are_plotted_in_degrees():
    spectrum = sphvar.spectrum("jittered", 48, realizations=4, pairs=True)
    axes = spectrum.plot(pairs=True)
    angles, values = labelled(axes)["jittered"].get_data()
    np.testing.assert_allclose(angles, np.degrees(spectrum.pairs["gamma"]))
    np.testing.assert_allclose(values, spectrum.pairs["g"])
    with pytest.raises(ValueError, match="pairs=True"):
        sphvar.spectrum("jittered", 48, realizations=4).plot(pairs=True)


@pytest.mark.parametrize("column", [1, 9, 20, 30])
def test_lights_are_where_the_image_has_them(column):
    image = np.full((16, 32), 1e-6)
    image[4, column] = 1
    axes = sphvar.lights(image, n=4).plot()
    x, y = np.median(np.ma.getdata(axes.collections[0].get_offsets()), axis=0)
    left, right = axes.get_xlim()
    bottom, top = axes.get_ylim()
    assert (x - left) / (right - left) * 32 == pytest.approx(column + 0.5, abs=0.6)
    assert (y - top) / (bottom - top) * 16 == pytest.approx(4.5, abs=0.6)


def test_the_legend_lists_only_what_is_drawn():
    document = sphvar.choose(["jittered", "white-noise"], integrand="cosine", n=48).to_dict()
    rows = {row["sampler"]: row for row in document["rows"]}
    rows["jittered"]["error"] = 0.0
    assert set(labelled(ChoiceResult(document).plot())) == {"white-noise"}
