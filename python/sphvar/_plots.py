"""Plots of results, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ._results import (
        AuditResult,
        BoundsResult,
        ChoiceResult,
        LightsResult,
        ProgressiveResult,
        QualityResult,
        RotationQualityResult,
        Row,
        VarianceResult,
    )

#: Colours of new axes, which the colour-blind distinguish (Okabe and Ito 2008).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f4a00", "#000000")

MARKERS = "osD^vPX*"

#: The maximum number of entries of a legend inside the axes; more would cover curves.
MAX_INSIDE = 4


def axes(ax: Axes | None) -> Axes:
    """Return the axes to plot on, those of a new figure if none are given."""
    if ax is not None:
        return ax
    try:
        from matplotlib import pyplot
    except ImportError as error:
        raise ImportError("plots need matplotlib: pip install sphvar[plot]") from error
    created: Axes = pyplot.subplots(layout="constrained")[1]
    created.set_prop_cycle(color=COLOURS)
    return created


def style(ax: Axes) -> tuple[Any, str]:
    """Return the colour and the marker of the next curve.

    The colour is the next of the property cycle of the axes, so that results plotted on the same axes
    differ from each other and from other curves.
    """
    (line,) = ax.plot([], [])
    colour = line.get_color()
    line.remove()
    return colour, MARKERS[len(ax.get_legend_handles_labels()[1]) % len(MARKERS)]


def legend(ax: Axes) -> None:
    """Add a legend of the labelled curves, beside the axes if it is long and the layout adapts."""
    entries = len(ax.get_legend_handles_labels()[1])
    if not entries:
        return
    engine = ax.figure.get_layout_engine()
    adapts = engine is not None and engine.adjust_compatible is False
    if entries > MAX_INSIDE and adapts:
        ax.legend(fontsize="small", loc="upper left", bbox_to_anchor=(1, 1), borderaxespad=0.2)
    else:
        ax.legend(fontsize="small")


def column(rows: list[Row], key: str) -> NDArray[np.float64]:
    """Return a column of numbers, with NaN for those that are unavailable."""
    entries = [row.get(key) for row in rows]
    return np.array([np.nan if entry is None else entry for entry in entries], dtype=np.float64)


def grouped(rows: list[Row]) -> dict[tuple[str, str], list[Row]]:
    """Return the rows of each sampler and integrand, sorted by the number of points."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["sampler"], row.get("integrand", "")), []).append(row)
    return {key: sorted(group, key=lambda row: int(row["n"])) for key, group in groups.items()}


def curves(ax: Axes, rows: list[Row], labels: dict[str, str], roots: bool) -> None:
    """Plot predicted variances as lines and measured ones as markers, or their square roots."""
    groups = grouped(rows)
    several = len({integrand for _, integrand in groups}) > 1
    for (sampler, integrand), group in groups.items():
        colour, marker = style(ax)
        label = labels.get(sampler, sampler) + (f", {integrand}" if several else "")
        n = column(group, "n")
        scaled = np.sqrt if roots else np.asarray
        predicted = scaled(column(group, "predicted"))
        measured = scaled(column(group, "measured"))
        if np.isfinite(predicted).any():
            # A single number of points is a line without length.
            small = "." if len(group) == 1 else None
            ax.plot(n, predicted, color=colour, marker=small, label=label)
            label = "_nolegend_"
        if np.isfinite(measured).any():
            low = scaled(column(group, "measured_low"))
            high = scaled(column(group, "measured_high"))
            bars = np.maximum(0, np.nan_to_num(np.array([measured - low, high - measured])))
            line = "none" if np.isfinite(predicted).any() else "-"
            ax.errorbar(
                n, measured, bars, color=colour, marker=marker, markersize=4, linestyle=line,
                capsize=2, linewidth=1, label=label,
            )  # fmt: skip


def logarithmic(ax: Axes, *, y: bool = True) -> None:
    """Make the horizontal axis logarithmic, the vertical one too unless told, with a grid."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    ax.set_xscale("log")
    low, high = ax.get_xlim()
    if high < 1000 * low:
        # Few decades: numbers between their ends, written plainly.
        ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ax.xaxis.set_minor_formatter(NullFormatter())
    if y:
        ax.set_yscale("log")
    ax.grid(alpha=0.3)


def variances(ax: Axes | None, result: VarianceResult, roots: bool) -> Axes:
    """Plot variances, or standard errors, against the number of points."""
    ax = axes(ax)
    rates = result._rates()
    labels = {name: f"{name}, $N^{{{rate:.2f}}}$" for name, rate in rates.items()}
    curves(ax, result.rows, labels, roots)
    logarithmic(ax)
    ax.set_xlabel("number of points N")
    ax.set_ylabel("standard error" if roots else "variance")
    integrands = {row.get("integrand") for row in result.rows}
    if len(integrands) == 1:
        ax.set_title(f"integrating {integrands.pop()}")
    legend(ax)
    return ax


def choice(ax: Axes | None, result: ChoiceResult, best: int) -> Axes:
    """Plot the predicted standard errors of the best samplers."""
    ax = axes(ax)
    for row in result.rows[:best]:
        if not row["error"]:
            # Exact, or without an error: nothing to draw on a logarithmic axis.
            continue
        colour, marker = style(ax)
        curve = sorted(row["curve"], key=lambda point: int(point["n"]))
        error = np.sqrt(column(curve, "variance"))
        ax.plot(column(curve, "n"), error, color=colour, linewidth=1)
        n, chosen = column([row], "n"), column([row], "error")
        ax.plot(n, chosen, color=colour, marker=marker, linestyle="none", label=row["sampler"])
    logarithmic(ax)
    if result.error_requested is not None:
        ax.axhline(result.error_requested, color="black", linestyle=":", linewidth=1)
    if result.points_requested is not None:
        ax.axvline(result.points_requested, color="black", linestyle=":", linewidth=1)
    ax.set_xlabel("number of points N")
    ax.set_ylabel("standard error")
    ax.set_title(f"integrating {result.integrand}")
    legend(ax)
    return ax


def progression(ax: Axes | None, result: ProgressiveResult, factors: bool) -> Axes:
    """Plot the standard errors of prefixes, or their factors over the reference."""
    ax = axes(ax)
    reference = " or ".join(dict.fromkeys(row["sampler"] for row in result.reference))
    if factors:
        for (sampler, _), group in grouped(result.rows).items():
            colour, marker = style(ax)
            n, factor = column(group, "n"), column(group, "factor")
            ax.plot(n, factor, color=colour, marker=marker, markersize=4, label=sampler)
        ax.axhline(1, color="black", linewidth=1)
        logarithmic(ax, y=False)
        ax.set_ylabel(f"standard error / {reference or 'reference'}")
    else:
        curves(ax, result.rows, {}, roots=True)
        for (sampler, _), group in grouped(result.reference).items():
            error = np.sqrt(column(group, "predicted"))
            ax.plot(column(group, "n"), error, color="black", linestyle="--", label=sampler)
        logarithmic(ax)
        ax.set_ylabel("standard error")
    ax.set_xlabel("number of points N")
    if result.rows:
        ax.set_title(f"prefixes, integrating {result.rows[0]['integrand']}")
    legend(ax)
    return ax


def spectrum(
    ax: Axes | None,
    l: NDArray[Any],
    power: NDArray[Any],
    stderr: NDArray[Any] | None,
    n: float,
    label: str | None = None,
    colour: Any = None,
) -> Axes:
    """Plot the power of every degree but 0 against ``omega = l / sqrt(n)``, with its error.

    Degrees without power are left out; the axes are logarithmic.
    """
    ax = axes(ax)
    colour = style(ax)[0] if colour is None else colour
    kept = (l > 0) & (power > 0)
    omega, power = l[kept] / np.sqrt(n), power[kept]
    ax.plot(omega, power, color=colour, linewidth=1, marker=".", markersize=3, label=label)
    if stderr is not None and np.isfinite(stderr).any():
        error = np.nan_to_num(np.asarray(stderr, dtype=np.float64)[kept])
        # A lower end of 0 or less is beyond a logarithmic axis.
        low = np.maximum(power - error, power / 10)
        ax.fill_between(omega, low, power + error, color=colour, alpha=0.25, linewidth=0)
    ax.axhline(1, color="grey", linewidth=0.5)
    logarithmic(ax)
    ax.set_xlabel(r"$\omega = l / \sqrt{N}$")
    ax.set_ylabel("power P(l)")
    if label is not None:
        legend(ax)
    return ax


def pairs(ax: Axes | None, pairs: dict[str, Any], label: str | None = None) -> Axes:
    """Plot the pair correlation against the angle, with its error; uniform points have 1."""
    ax = axes(ax)
    colour, _ = style(ax)
    angle = np.degrees(np.array(pairs["gamma"], dtype=np.float64))
    g = np.array(pairs["g"], dtype=np.float64)
    ax.plot(angle, g, color=colour, linewidth=1, label=label)
    error = np.array(pairs["stderr"], dtype=np.float64)
    if error.shape == g.shape and np.isfinite(error).any():
        error = np.nan_to_num(error)
        ax.fill_between(angle, g - error, g + error, color=colour, alpha=0.25, linewidth=0)
    ax.axhline(1, color="grey", linewidth=0.5)
    ax.set_ylim(bottom=0)
    ax.grid(alpha=0.3)
    ax.set_xlabel("angle between two points (degrees)")
    ax.set_ylabel("pair correlation g")
    legend(ax)
    return ax


def bounds(ax: Axes | None, result: BoundsResult, given: Any) -> Axes:
    """Plot profiles, upper ones solid, lower ones dashed."""
    ax = axes(ax)
    lmax = result.lmax or 4 * max(8, round(np.sqrt(result.n)))
    l = np.arange(1, lmax + 1)
    omega = l / np.sqrt(result.n)
    if given is not None:
        spectrum(ax, given.l, given.power, None, given.n, "spectrum", "black")
    families = dict.fromkeys(row["family"] for row in result.rows)
    colours = {family: style(ax)[0] for family in families}
    for row in result.rows:
        relative = omega / row["alpha"]
        if row["family"] == "step":
            rise = (relative >= 1).astype(float)
        else:
            rise = np.minimum(1, relative) ** (row["exponent"] or 0)
        profile = row["offset"] + row["gamma"] * rise
        dash = "--" if row["side"] == "lower" else "-"
        shown = np.where(profile > 0, profile, np.nan)
        name = row["family"] if row["side"] == "given" else f"{row['side']} {row['family']}"
        ax.plot(
            omega, shown, color=colours[row["family"]], linestyle=dash, linewidth=1, label=name
        )
    logarithmic(ax)
    # Steep profiles fall below anything that matters.
    low, high = ax.get_ylim()
    ax.set_ylim(max(low, 1e-8 * high), high)
    ax.set_xlabel(r"$\omega = l / \sqrt{N}$")
    ax.set_ylabel("power P(l)")
    ax.set_title(f"bounds, N = {result.n}")
    legend(ax)
    return ax


def audit(ax: Axes | None, result: AuditResult) -> Axes:
    """Plot the mean squared errors of harmonics over their predicted variances."""
    ax = axes(ax)
    for index, row in enumerate(result.rows):
        # Ratios of 0 are those of harmonics that every set integrates exactly.
        ratios = [r for r in row["ratios"] if r["ratio"] is not None and r["ratio"] > 1e-9]
        degree, order = column(ratios, "l"), column(ratios, "m")
        place = degree + 0.7 * order / (degree + 1) + 0.15 * index / (degree + 1)
        ratio = column(ratios, "ratio")
        ends = np.array([ratio - column(ratios, "low"), column(ratios, "high") - ratio])
        colour, marker = style(ax)
        ax.errorbar(
            place, ratio, np.maximum(0, np.nan_to_num(ends)), color=colour, marker=marker,
            markersize=4, linestyle="none", linewidth=1, capsize=2, label=row["ensemble"],
        )  # fmt: skip
    ax.axhline(1, color="black", linewidth=1)
    ax.grid(alpha=0.3)
    ax.set_xlabel("degree l, orders m = 0 to l from left to right")
    ax.set_ylabel("mean squared error / variance formula")
    ax.set_title(f"integration errors of $Y_{{lm}}$ with {result.sampler}, N = {result.n}")
    legend(ax)
    return ax


def quality(ax: Axes | None, result: QualityResult) -> Axes:
    """Plot scaled measures of which less is better."""
    ax = axes(ax)
    square = any("star_discrepancy" in row for row in result.rows)
    measures = _measures(result.rows, square)
    for index, row in enumerate(result.rows):
        colour, marker = style(ax)
        place = np.arange(len(measures)) + 0.08 * (index - (len(result) - 1) / 2)
        value = np.array([values[index] for values in measures.values()])
        label = f"{row['sampler']}, N = {row['n']}"
        ax.plot(place, value, color=colour, marker=marker, linestyle="none", label=label)
    ax.set_yscale("log")
    ax.grid(alpha=0.3)
    ax.set_xticks(range(len(measures)), list(measures), rotation=30, ha="right")
    ax.set_ylabel("measure" if square else "measure, scaled by a power of N")
    legend(ax)
    return ax


def _measures(rows: list[Row], square: bool) -> dict[str, NDArray[np.float64]]:
    """Return measures of which less is better, scaled where they depend on N, for all rows."""
    if square:
        names = {
            "star disc.": "star_discrepancy",
            "L2 star disc.": "l2_star_discrepancy",
            "wrap-around": "wraparound_l2_discrepancy",
        }
        separation = "relative_separation"
        errors: dict[str, NDArray[np.float64]] = {}
    else:
        rows = [row["scaled"] for row in rows]
        names = {
            "covering": "covering_radius",
            "mesh ratio": "mesh_ratio",
            "cap disc.": "cap_discrepancy_l2",
            "gen. disc.": "generalized_discrepancy",
        }
        separation = "separation"
        errors = {
            f"error, s = {s}": column([row["worst_case_error"] for row in rows], s)
            for s in dict.fromkeys(s for row in rows for s in row["worst_case_error"])
        }
    with np.errstate(divide="ignore"):
        measures = {"1 / separation": 1 / column(rows, separation)}
    return measures | {title: column(rows, key) for title, key in names.items()} | errors


def lights(ax: Axes | None, result: LightsResult) -> Axes:
    """Plot lights where the image has them, or errors against the number of lights.

    The longitude runs as in an image without the options ``mirror``, ``rotate`` and ``up``.
    """
    ax = axes(ax)
    if result.to_dict()["rows"] is None:
        for (sampler, _), group in grouped(result.rows).items():
            colour, marker = style(ax)
            n, error, bars = (column(group, key) for key in ("n", "error", "error_stderr"))
            bars = np.nan_to_num(bars)
            ax.errorbar(
                n, error, bars, color=colour, marker=marker, markersize=4, capsize=2, label=sampler
            )
        logarithmic(ax)
        ax.set_xlabel("number of lights N")
        ax.set_ylabel("relative error of the irradiance")
        legend(ax)
        return ax
    directions, rgb = result.directions, np.maximum(0, result.rgb)
    x, y, z = directions.T
    # Images have +y at the left edge and longitudes that decrease to the right: 90 to -270 degrees.
    longitude = 90 - (90 - np.degrees(np.arctan2(y, x))) % 360
    latitude = np.degrees(np.arctan2(z, np.hypot(x, y)))
    luminance = rgb @ [0.2126, 0.7152, 0.0722]
    area = 20 + 400 * luminance / max(luminance.max(initial=0), np.finfo(float).tiny)
    largest = np.maximum(rgb.max(axis=1, keepdims=True), np.finfo(float).tiny)
    ax.scatter(longitude, latitude, s=area, c=rgb / largest, edgecolors="grey", linewidths=0.5)
    ax.set_facecolor("#202020")
    ax.set_xlim(90, -270)
    ax.set_ylim(-90, 90)
    ax.set_xticks(range(90, -271, -90))
    ax.set_yticks(range(-90, 91, 45))
    ax.set_aspect("equal")
    ax.set_xlabel("longitude (degrees)")
    ax.set_ylabel("latitude (degrees)")
    if result.irradiance_error is not None:
        ax.set_title(f"{len(rgb)} lights, error of the irradiance {result.irradiance_error:.3g}")
    return ax


def rotations(ax: Axes | None, result: RotationQualityResult) -> Axes:
    """Plot the power of each degree of sets of rotations."""
    ax = axes(ax)
    from matplotlib.ticker import MaxNLocator

    for row in result.rows:
        colour, marker = style(ax)
        power = np.array(row["power"][1:], dtype=np.float64)
        error = row["power_stderr"]
        bars = None if error is None else np.array(error[1:], dtype=np.float64)
        label = f"{row['sampler']}, N = {row['n']}"
        ax.errorbar(
            np.arange(1, len(power) + 1), power, bars, color=colour, marker=marker, markersize=4,
            capsize=2, linewidth=1, label=label,
        )  # fmt: skip
    ax.axhline(1, color="grey", linewidth=0.5)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.grid(alpha=0.3)
    ax.set_xlabel("degree l")
    ax.set_ylabel("power, uniform rotations = 1")
    legend(ax)
    return ax
