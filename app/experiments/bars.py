"""A bar chart as SVG: one named amount a line, the largest on top; for prices, which have names but no error."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

_WIDTH, _NAMES, _LINE, _TOP, _BOTTOM, _RIGHT = 900, 210, 18, 8, 26, 60
_COLOUR = "#0072b2"


@dataclass(frozen=True)
class Bars:
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


def bars_svg(bars: Bars) -> str:
    """The chart as one SVG element, on a linear axis from zero, each bar with its number behind it."""
    shown = sorted(((v, name) for name, v in bars.amounts.items() if math.isfinite(v)), reverse=True)
    height = _TOP + _LINE * max(len(shown), 1) + _BOTTOM
    most = max([value for value, _ in shown if value > 0], default=1.0)
    lines = "".join(_bar(number, name, value, most) for number, (value, name) in enumerate(shown))
    axis = f'<text x="{_NAMES}" y="{height - 8}" fill="#444">{escape(bars.x)}</text>'
    size = f'viewBox="0 0 {_WIDTH} {height}" width="{_WIDTH}" height="{height}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" font-family="sans-serif" font-size="11">'
    nothing = "" if shown else f'<text x="{_NAMES}" y="{_TOP + 12}" fill="#888">nothing measured</text>'
    return f"{head}<title>{escape(bars.title)}</title>{lines}{nothing}{axis}</svg>"


def _bar(number: int, name: str, value: float, most: float) -> str:
    y, long = _TOP + _LINE * number, max(value, 0.0) / most * (_WIDTH - _NAMES - _RIGHT)
    return (
        f'<text x="{_NAMES - 8}" y="{y + 12}" text-anchor="end">{escape(name)}</text>'
        f'<rect x="{_NAMES}" y="{y + 2}" width="{long:.1f}" height="{_LINE - 4}" fill="{_COLOUR}"/>'
        f'<text x="{_NAMES + long + 4:.1f}" y="{y + 12}">{value:.3g}</text>'
    )
