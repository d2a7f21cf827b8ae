"""Figures of a study, drawn with matplotlib: curves on logarithmic axes, and bars.

A ``Figure`` is a work-precision diagram: error against time, both logarithmic, one curve a method, one panel a subject.
A ``BarChart`` has one named amount a line, the largest on top: for costs, which have names but no error.
``panels`` makes panels from rows. ``figure_svg`` gives an element for an HTML page that is the same at every run; what
is drawn in the text's colour follows the page, light or dark. Other colours are Okabe and Ito's, which colour-blind
people can tell apart.
"""

from __future__ import annotations

import hashlib
import io
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.studies.base.rows import Row, number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure as Canvas

_INK = "#010101"
"""Drawn so and then written as ``currentColor``; plain black is left out of SVG by matplotlib."""
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", _INK)
_MARKERS = "osD^v"
"""For more curves than there are colours."""
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "text.parse_math": False,
    "font.size": 8.0,
    "font.sans-serif": ["DejaVu Sans"],
    "lines.markersize": 3.0,
    "lines.linewidth": 1.2,
    "axes.titlesize": 8.0,
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    **dict.fromkeys(
        ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color", "grid.color"), _INK
    ),
    "grid.alpha": 0.2,
}
_WIDTH = 3.1
_HEIGHT = 2.5
_LEGEND = 1.9
"""Of a panel, and of the legend [inch]."""
_BAR_WIDTH = 9.0
_BAR_PITCH = 0.2
_BAR_AXIS = 0.7
_COLUMNS = 3
_MARGIN = 0.25
"""At least so many decades are shown on either side of the points: a tick lies within."""

Points = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Panel:
    """One diagram.

    Attributes:
        title: What is the same for all its curves.
        curves: Points (x, y) by method, in the order they are joined.
        intervals: (x, low, high) by method, drawn as upright lines: confidence intervals of the points. One with
            an infinite high ends in an arrow at the top.
    """

    title: str
    curves: Mapping[str, Points]
    intervals: Mapping[str, Sequence[tuple[float, float, float]]] = field(default_factory=dict)


@dataclass(frozen=True)
class Figure:
    """Diagrams with the same axes' names, to be read together.

    Attributes:
        title: The question.
        x: Name and unit of the horizontal axis.
        y: Likewise of the vertical one.
        panels: One for each subject.
        least: Smaller errors are drawn here: a logarithm knows no zero.
        note: What has to be said beside it, in a sentence or two.
    """

    title: str
    x: str
    y: str
    panels: Sequence[Panel]
    least: float = 1e-9
    note: str = ""


@dataclass(frozen=True)
class BarChart:
    """Amounts by name.

    Attributes:
        title: The question.
        x: What the amounts are, with their unit.
        amounts: None where it is not known; that and what is infinite is left out.
        note: What has to be said beside it, in a sentence or two.
        intervals: (low, high) of amounts by name: confidence intervals, drawn over the bars and written beside them.
    """

    title: str
    x: str
    amounts: Mapping[str, float | None]
    note: str = ""
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def panels(
    rows: Sequence[Row], panel: Callable[[Row], str], curve: Callable[[Row], str], *, x: str, y: str
) -> list[Panel]:
    """One panel for each title that ``panel`` gives, one curve for each name that ``curve`` gives, as they first come.

    A row without one of the two numbers is no point of its curve.

    Args:
        rows: Of a study; points are joined in their order.
        panel: The title of a row's panel.
        curve: The name of a row's curve.
        x: A column.
        y: Another one.
    """
    found: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for row in rows:
        points = found.setdefault(panel(row), {}).setdefault(curve(row), [])
        at = number(row.get(x))
        height = number(row.get(y))
        if at is not None and height is not None:
            points.append((at, height))
    return [Panel(title, curves) for title, curves in found.items()]


def figure_svg(figure: Figure | BarChart) -> str:
    """The figure as one SVG element, to stand in an HTML page among others; the point under the pointer tells its
    numbers.

    Cost: 0.1 s a panel, 1 s for the first.
    """
    from matplotlib import rc_context

    prefix = hashlib.blake2b(figure.title.encode(), digest_size=4).hexdigest()
    with rc_context({**_STYLE, "svg.hashsalt": prefix}):
        text = io.StringIO()
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        draw(figure).savefig(text, format="svg", transparent=True, metadata=nothing)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :].replace(_INK, "currentColor")
    for group, titles in _point_titles(figure):
        svg = _with_titles(svg, group, titles)
    # Several figures stand in one page: each has names of its own.
    svg = re.sub(r'( id="|url\(#|href="#)', rf"\g<1>f{prefix}-", svg)
    head, _, body = svg.partition(">")
    return f'{head} role="img"><title>{escape(figure.title)}</title>{body.strip()}'


def _point_titles(figure: Figure | BarChart) -> Iterator[tuple[str, list[str]]]:
    """Of each curve its group in the SVG, and what each of its points says; bars have their numbers beside them."""
    if isinstance(figure, BarChart):
        return
    for place, panel in enumerate(figure.panels):
        for order, (name, points) in enumerate(panel.curves.items()):
            spans = {x: f" [{low:.3g}, {high:.3g}]" for x, low, high in panel.intervals.get(name, ())}
            yield (
                _group(place, order),
                [
                    f"{panel.title}, {name}\n{figure.x}: {x:.4g}\n{figure.y}: {y:.3g}{spans.get(x, '')}"
                    for x, y in _drawable(points, figure.least).tolist()
                ],
            )


def _group(panel: int, curve: int) -> str:
    return f"points-{panel}-{curve}"


def _with_titles(svg: str, group: str, titles: Sequence[str]) -> str:
    """The SVG with a title in each marker of a group; browsers show it beside the pointer."""
    head, start, rest = svg.partition(f'<g id="{group}">')
    own, following, tail = rest.partition('<g id="')
    each = iter(titles)
    own = re.sub(r"<use ([^>]*)/>", lambda found: f"<use {found[1]}><title>{escape(next(each))}</title></use>", own)
    return head + start + own + following + tail


def draw(figure: Figure | BarChart) -> Canvas:
    """The figure as one of matplotlib's, which belongs to no window. A method keeps its colour in all panels."""
    return _draw_bars(figure) if isinstance(figure, BarChart) else _draw_panels(figure)


def _draw_panels(figure: Figure) -> Canvas:
    from matplotlib.figure import Figure as Canvas
    from matplotlib.lines import Line2D

    columns = max(min(_COLUMNS, len(figure.panels)), 1)
    rows = max(-(-len(figure.panels) // columns), 1)
    canvas = Canvas(figsize=(columns * _WIDTH + _LEGEND, rows * _HEIGHT), layout="constrained")
    names = list(dict.fromkeys(name for panel in figure.panels for name in panel.curves))
    looks = {
        name: (_COLOURS[k % len(_COLOURS)], _MARKERS[k // len(_COLOURS) % len(_MARKERS)])
        for k, name in enumerate(names)
    }
    for place, panel in enumerate(figure.panels):
        axes = canvas.add_subplot(rows, columns, place + 1)
        axes.set_title(panel.title)
        _draw_panel(axes, place, figure, looks)
    if names:
        keys = [Line2D([], [], color=colour, marker=marker) for colour, marker in looks.values()]
        canvas.legend(keys, names, loc="outside right upper", frameon=False)
    return canvas


def _draw_panel(axes: Axes, place: int, figure: Figure, looks: Mapping[str, tuple[str, str]]) -> None:
    panel = figure.panels[place]
    curves = {name: _drawable(points, figure.least) for name, points in panel.curves.items()}
    spans = {
        name: [(x, max(low, figure.least), high) for x, low, high in rows if x > 0 and np.isfinite([x, low]).all()]
        for name, rows in panel.intervals.items()
        if name in curves
    }
    ends = [(x, y) for rows in spans.values() for x, *both in rows for y in both]
    every = np.concatenate([*curves.values(), _drawable(ends, figure.least)])
    if not len(every):
        _say_nothing_measured(axes)
        return
    axes.set(xscale="log", yscale="log", xlabel=figure.x, ylabel=figure.y)
    axes.grid(visible=True)
    (left, bottom), (right, top) = every.min(axis=0).tolist(), every.max(axis=0).tolist()
    axes.set(xlim=_limits(axes.xaxis, left, right), ylim=_limits(axes.yaxis, bottom, top))
    for order, (name, points) in enumerate(curves.items()):
        if len(points):
            colour, marker = looks[name]
            axes.plot(*points.T, label=name, color=colour, marker=marker, gid=_group(place, order))
    highest = axes.get_ylim()[1]
    for name, rows in spans.items():
        line: dict[str, Any] = {"color": looks[name][0], "alpha": 0.6, "label": "_interval", "clip_on": False}
        for x, low, high in rows:
            axes.plot([x, x], [low, min(high, highest)], linewidth=0.8, **line)
            if math.isinf(high):
                axes.plot([x], [highest], marker="^", **line)


def _drawable(points: Points, least: float) -> FloatArray:
    """The points (k, 2) that have a logarithm."""
    kept = [(x, max(y, least)) for x, y in points if np.isfinite([x, y]).all() and x > 0]
    return np.array(kept, dtype=np.float64).reshape(-1, 2)


def _limits(axis: Axis, low: float, high: float) -> tuple[float, float]:
    """``low`` and ``high`` with a margin; ticks are set at powers of ten, or at 1, 2 and 5 where these are few."""
    from matplotlib.ticker import LogLocator, NullFormatter

    start = math.log10(low)
    end = math.log10(high)
    margin = max(0.06 * (end - start), _MARGIN)
    few = end - start + 2 * margin < 2
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if few else (1,), numticks=8))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())
    return 10 ** (start - margin), 10 ** (end + margin)


def _draw_bars(chart: BarChart) -> Canvas:
    from matplotlib.figure import Figure as Canvas

    known = ((value, name) for name, value in chart.amounts.items() if value is not None)
    shown = sorted((value, name) for value, name in known if math.isfinite(value))
    spans = [chart.intervals.get(name, (value, value)) for value, name in shown]
    canvas = Canvas(figsize=(_BAR_WIDTH, _BAR_PITCH * max(len(shown), 1) + _BAR_AXIS), layout="constrained")
    axes = canvas.add_subplot()
    if not shown:
        _say_nothing_measured(axes)
        return canvas
    axes.barh([name for _, name in shown], [value for value, _ in shown], color=_COLOURS[0])
    for place, ((value, name), (low, high)) in enumerate(zip(shown, spans, strict=True)):
        text = f"{value:.3g}" + (f" [{low:.3g}, {high:.3g}]" if name in chart.intervals else "")
        end = high if math.isfinite(high) else value
        axes.plot([low, end], [place, place], color=_INK, linewidth=0.8)
        axes.annotate(text, (end, place), (3, 0), textcoords="offset points", va="center")
    axes.margins(x=0.2 if chart.intervals else 0.08, y=0.02)
    axes.set_xlabel(chart.x)
    return canvas


def _say_nothing_measured(axes: Axes) -> None:
    axes.set_axis_off()
    axes.text(0.5, 0.5, "nothing measured", ha="center", va="center", transform=axes.transAxes)
