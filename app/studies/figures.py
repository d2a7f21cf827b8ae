"""Figures of a study as SVG: curves on logarithmic axes, and bars.

A ``Figure`` is a work-precision diagram: error against seconds, both logarithmic, one curve a method, one panel a
setting. A ``BarChart`` has one named amount a line, the largest on top: for costs, which have names but no error.
Colours are Okabe and Ito's, told apart by everybody.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from html import escape

import numpy as np

from app.core.arrays import FloatArray

_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f7f7f", "#000000")
"""Okabe and Ito's, told apart by everybody."""
_WIDTH, _HEIGHT, _LEFT, _TOP, _RIGHT, _BOTTOM = 330, 250, 58, 30, 12, 44
_LEGEND, _LINE = 190, 17
_COLUMNS = 3
_MOST_TICKS = 6

Points = Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Panel:
    """One diagram.

    Attributes:
        title: What is the same for all its curves.
        curves: Points (x, y) by method, in the order they are joined.
        spreads: (x, lowest, highest) by method, drawn as upright lines: how sure the points are.
    """

    title: str
    curves: Mapping[str, Points]
    spreads: Mapping[str, Sequence[tuple[float, float, float]]] = field(default_factory=dict)


@dataclass(frozen=True)
class Figure:
    """Diagrams with the same axes' names, to be read together.

    Attributes:
        title: The question.
        x: Name and unit of the horizontal axis.
        y: Likewise of the vertical one.
        panels: One for each setting.
        least: Smaller errors are drawn here: a logarithm knows no zero.
        note: What has to be said beside it, in a sentence or two.
    """

    title: str
    x: str
    y: str
    panels: Sequence[Panel]
    least: float = 1e-9
    note: str = ""


def figure_svg(figure: Figure) -> str:
    """The figure as one SVG element. A method keeps its colour in all panels; what is not finite does not show."""
    names = list(dict.fromkeys(name for panel in figure.panels for name in panel.curves))
    colour = {name: _COLOURS[k % len(_COLOURS)] for k, name in enumerate(names)}
    columns = max(min(_COLUMNS, len(figure.panels)), 1)
    rows = -(-len(figure.panels) // columns)
    width, height = columns * _WIDTH + _LEGEND, max(rows * _HEIGHT, _TOP + _LINE * len(colour))
    parts = [f'<g transform="translate({columns * _WIDTH},{_TOP})">{_legend(colour)}</g>']
    for number, panel in enumerate(figure.panels):
        row, column = divmod(number, columns)
        inner = _panel(panel, figure, colour)
        parts.append(f'<g transform="translate({column * _WIDTH},{row * _HEIGHT})">{inner}</g>')
    size = f'viewBox="0 0 {width} {height}" width="{width}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" font-family="sans-serif" font-size="11">'
    return f"{head}<title>{escape(figure.title)}</title>{''.join(parts)}</svg>"


def _panel(panel: Panel, figure: Figure, colour: Mapping[str, str]) -> str:
    curves = {name: _log_points(points, figure.least) for name, points in panel.curves.items()}
    spans = {name: _log_intervals(rows, figure.least) for name, rows in panel.spreads.items() if name in curves}
    every = np.concatenate([*curves.values(), *(ends.reshape(-1, 2) for ends in spans.values()), np.zeros((0, 2))])
    title = _text(_WIDTH / 2, 18, panel.title, 'text-anchor="middle" font-weight="bold"')
    if not len(every):
        return title + _text(_WIDTH / 2, _HEIGHT / 2, "nothing measured", 'text-anchor="middle" fill="#888"')
    axes = _Axes.around(every)
    lines = [_curve(axes.place(points), name, colour[name]) for name, points in curves.items() if len(points)]
    lines += [_interval_line(axes.place(ends), colour[name]) for name, rows in spans.items() for ends in rows]
    return title + axes.drawn(figure) + "".join(lines)


def _log_points(points: Points, least: float) -> FloatArray:
    """Decimal logarithms (k, 2) of the points that have them."""
    kept = [(x, max(y, least)) for x, y in points if np.isfinite([x, y]).all() and x > 0]
    return np.asarray(np.log10(np.array(kept, dtype=np.float64).reshape(-1, 2)))


def _log_intervals(rows: Sequence[tuple[float, float, float]], least: float) -> FloatArray:
    """Decimal logarithms (k, 2, 2) of both ends of the upright lines that have them."""
    ends = [_log_points([(x, low), (x, high)], least) for x, low, high in rows]
    return np.array([pair for pair in ends if len(pair) == 2]).reshape(-1, 2, 2)


@dataclass(frozen=True, eq=False)
class _Axes:
    """Corners (2,) of what is shown, as decimal logarithms."""

    low: FloatArray
    high: FloatArray

    @staticmethod
    def around(points: FloatArray) -> _Axes:
        low, high = points.min(axis=0), points.max(axis=0)
        margin = np.maximum(0.06 * (high - low), 0.1)
        return _Axes(low - margin, high + margin)

    def place(self, points: FloatArray) -> FloatArray:
        """Where ``points`` (k, 2) lie in the panel, y down."""
        share = (points - self.low) / (self.high - self.low)
        size = np.array([_WIDTH - _LEFT - _RIGHT, _TOP + _BOTTOM - _HEIGHT])
        return share * size + [_LEFT, _HEIGHT - _BOTTOM]

    def drawn(self, figure: Figure) -> str:
        """Frame, grid lines at round numbers, and names."""
        (left, bottom), (right, top) = self.place(np.stack([self.low, self.high]))
        parts = [f'<path d="M{left:.1f},{top:.1f}V{bottom:.1f}H{right:.1f}" fill="none" stroke="#444"/>']
        for value in _ticks(self.low[0], self.high[0]):
            x = self.place(np.array([[value, 0.0]]))[0, 0]
            parts.append(f'<path d="M{x:.1f},{top:.1f}V{bottom:.1f}" stroke="#ddd"/>')
            parts.append(_text(x, bottom + 14, _label(value), 'text-anchor="middle"'))
        for value in _ticks(self.low[1], self.high[1]):
            y = self.place(np.array([[0.0, value]]))[0, 1]
            parts.append(f'<path d="M{left:.1f},{y:.1f}H{right:.1f}" stroke="#ddd"/>')
            parts.append(_text(left - 4, y + 4, _label(value), 'text-anchor="end"'))
        parts.append(_text(0.5 * (left + right), bottom + 32, figure.x, 'text-anchor="middle"'))
        middle = 0.5 * (top + bottom)
        parts.append(_text(12, middle, figure.y, f'text-anchor="middle" transform="rotate(-90 12 {middle:.1f})"'))
        return "".join(parts)


def _ticks(low: float, high: float) -> FloatArray:
    """Logarithms of a few powers of ten within; of 1, 2 and 5 times them where there is but one or none."""
    decades = np.arange(np.ceil(low), np.floor(high) + 1)
    if len(decades) > 1:
        return decades[:: -(-len(decades) // _MOST_TICKS)]
    fine = np.add.outer(np.arange(np.floor(low), high + 1), np.log10([1, 2, 5])).ravel()
    return fine[(fine >= low) & (fine <= high)]


def _label(value: float) -> str:
    return f"{10**value:.0e}".replace("e-0", "e-").replace("e+0", "e") if abs(value) > 3 else f"{10**value:.4g}"


def _curve(places: FloatArray, name: str, colour: str) -> str:
    line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6"/>' for x, y in places)
    joined = f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="1.6"/>'
    return f'<g fill="{colour}"><title>{escape(name)}</title>{joined}{dots}</g>'


def _interval_line(ends: FloatArray, colour: str) -> str:
    (x, low), (_, high) = ends
    return f'<path d="M{x:.1f},{low:.1f}V{high:.1f}" stroke="{colour}" stroke-width="1" opacity="0.6"/>'


def _legend(colour: Mapping[str, str]) -> str:
    rows = [
        f'<circle cx="12" cy="{_LINE * k + 8}" r="4" fill="{shade}"/>' + _text(22, _LINE * k + 12, name, "")
        for k, (name, shade) in enumerate(colour.items())
    ]
    return "".join(rows)


def _text(x: float, y: float, text: str, style: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" {style}>{escape(text)}</text>'


_CHART_WIDTH, _LABEL_WIDTH, _BAR_PITCH, _CHART_TOP, _CHART_BOTTOM, _CHART_RIGHT = 900, 210, 18, 8, 26, 60
_BAR_COLOUR = "#0072b2"


@dataclass(frozen=True)
class BarChart:
    """Amounts by name.

    Attributes:
        title: The question.
        x: What the amounts are, with their unit.
        amounts: Not below zero; what is not finite does not show.
        note: What has to be said beside it, in a sentence or two.
    """

    title: str
    x: str
    amounts: Mapping[str, float]
    note: str = ""


def bar_chart_svg(bars: BarChart) -> str:
    """The chart as one SVG element, on a linear axis from zero, each bar with its number behind it."""
    shown = sorted(((v, name) for name, v in bars.amounts.items() if math.isfinite(v)), reverse=True)
    height = _CHART_TOP + _BAR_PITCH * max(len(shown), 1) + _CHART_BOTTOM
    most = max([value for value, _ in shown if value > 0], default=1.0)
    lines = "".join(_bar(number, name, value, most) for number, (value, name) in enumerate(shown))
    axis = f'<text x="{_LABEL_WIDTH}" y="{height - 8}" fill="#444">{escape(bars.x)}</text>'
    size = f'viewBox="0 0 {_CHART_WIDTH} {height}" width="{_CHART_WIDTH}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" font-family="sans-serif" font-size="11">'
    nothing = "" if shown else f'<text x="{_LABEL_WIDTH}" y="{_CHART_TOP + 12}" fill="#888">nothing measured</text>'
    return f"{head}<title>{escape(bars.title)}</title>{lines}{nothing}{axis}</svg>"


def _bar(number: int, name: str, value: float, most: float) -> str:
    y, long = _CHART_TOP + _BAR_PITCH * number, max(value, 0.0) / most * (_CHART_WIDTH - _LABEL_WIDTH - _CHART_RIGHT)
    return (
        f'<text x="{_LABEL_WIDTH - 8}" y="{y + 12}" text-anchor="end">{escape(name)}</text>'
        f'<rect x="{_LABEL_WIDTH}" y="{y + 2}" width="{long:.1f}" height="{_BAR_PITCH - 4}" fill="{_BAR_COLOUR}"/>'
        f'<text x="{_LABEL_WIDTH + long + 4:.1f}" y="{y + 12}">{value:.3g}</text>'
    )
