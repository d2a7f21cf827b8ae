"""Figures of a study, drawn with matplotlib: curves on logarithmic axes, and bars.

A ``Figure`` is a work-precision diagram: error against time on logarithmic axes, one curve a method, one panel a
subject. A ``BarChart`` shows named amounts without error, sorted, the largest on top. ``panels`` creates panels from
rows. ``figure_svg`` returns a reproducible element for an HTML page; parts in the text colour follow the light or dark
page. The other colours are those of Okabe and Ito, which are distinguishable with colour blindness.
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
"""Drawn in this colour and then replaced by ``currentColor``; matplotlib omits plain black from SVG."""
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", _INK)
_MARKERS = "osD^v"
"""Markers that distinguish curves when there are more curves than colours."""
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
"""Size of a panel, and width of the legend [inch]."""
_BAR_WIDTH = 9.0
_BAR_PITCH = 0.2
_BAR_AXIS = 0.7
_COLUMNS = 3
_MARGIN = 0.25
"""Minimum margin around the points, in decades; it guarantees a tick within the axis."""

Points = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Panel:
    """A diagram.

    Attributes:
        title: Common property of all its curves.
        curves: Points (x, y) by method, in the order in which they are joined.
        intervals: Confidence intervals (x, low, high) by method, drawn as vertical bars; one with an infinite high
            end has an arrow at the top.
    """

    title: str
    curves: Mapping[str, Points]
    intervals: Mapping[str, Sequence[tuple[float, float, float]]] = field(default_factory=dict)


@dataclass(frozen=True)
class Figure:
    """Diagrams with common axis labels, to be compared.

    Attributes:
        title: The question.
        x: Name and unit of the horizontal axis.
        y: Name and unit of the vertical axis.
        panels: One panel for each subject.
        least: Smaller errors are drawn at this value, because a logarithmic axis has no zero.
        note: Explanation next to the figure, in a sentence or two.
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
        x: Name and unit of the amounts.
        amounts: Amounts by name; None where unknown. Unknown and infinite amounts are left out.
        note: Explanation next to the figure, in a sentence or two.
        intervals: Confidence intervals (low, high) by name, drawn over the bars and written next to them.
    """

    title: str
    x: str
    amounts: Mapping[str, float | None]
    note: str = ""
    intervals: Mapping[str, tuple[float, float]] = field(default_factory=dict)


def panels(
    rows: Sequence[Row], panel: Callable[[Row], str], curve: Callable[[Row], str], *, x: str, y: str
) -> list[Panel]:
    """Return one panel for each title and one curve for each curve name, in order of first occurrence.

    Rows without one of the two numbers are left out.

    Args:
        rows: Rows of a study; points are joined in their order.
        panel: Returns the title of the panel of a row.
        curve: Returns the name of the curve of a row.
        x: Column of the horizontal axis.
        y: Column of the vertical axis.
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
    """Return the figure as one SVG element for an HTML page; hovering over a point shows its numbers.

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
    # Several figures share one page: each has its own names.
    svg = re.sub(r'( id="|url\(#|href="#)', rf"\g<1>f{prefix}-", svg)
    head, _, body = svg.partition(">")
    return f'{head} role="img"><title>{escape(figure.title)}</title>{body.strip()}'


def _point_titles(figure: Figure | BarChart) -> Iterator[tuple[str, list[str]]]:
    """SVG group of each curve and the tooltips of its points; bars have their numbers next to them."""
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
    """Add a title, which browsers show as a tooltip, to each marker of a group of the SVG."""
    head, start, rest = svg.partition(f'<g id="{group}">')
    own, following, tail = rest.partition('<g id="')
    each = iter(titles)
    own = re.sub(r"<use ([^>]*)/>", lambda found: f"<use {found[1]}><title>{escape(next(each))}</title></use>", own)
    return head + start + own + following + tail


def draw(figure: Figure | BarChart) -> Canvas:
    """Return the figure as a matplotlib figure without a window. A method keeps its colour in all panels."""
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
    """Limits with a margin; ticks are at powers of ten, or at 1, 2 and 5 in a short range."""
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
