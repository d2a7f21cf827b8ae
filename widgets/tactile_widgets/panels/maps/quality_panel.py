"""Quality of the map: the few numbers that matter, an explanation of each, and a mark at bad ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import counted
from tactile_maps.maps.evaluation.comparison import Comparison
from tactile_maps.maps.evaluation.quality import MapQuality
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import LOW_COVERAGE
from tactile_widgets.common.make import row_layout, value_label
from tactile_widgets.common.panel import Panel

_MARK = "▲"
_UNKNOWN = "–"


@dataclass(frozen=True)
class _Measure:
    """A measure of the card.

    Attributes:
        key: Key in ``MapQuality.to_json``.
        name: Displayed name.
        form: Formats the value.
        tip: Explanation for a reader who does not know the term.
        bad: Whether a value is so bad that the map misleads.
        said: Name within a sentence.
    """

    key: str
    name: str
    form: Callable[[Any], str]
    tip: str
    bad: Callable[[Any], bool]
    said: str = ""


def _percent(value: float) -> str:
    return f"{100 * value:.1f}\u202f%"


def _three_digits(value: float) -> str:
    """Format with three digits: two columns have to fit."""
    return f"{value:.{2 if value < 10 else 1 if value < 100 else 0}f}"


def _stretch_text(value: Mapping[str, float]) -> str:
    return f"×{_three_digits(value['p95'])}" if value["p95"] is not None else "∞"


def _stretch_bad(value: Mapping[str, float | None]) -> bool:
    return value["p95"] is None or value["p95"] > 2


_MEASURES = (
    _Measure(
        "bijective",
        "One-to-one",
        lambda v: "yes" if v else "no",
        "Bijective: every map point is one body point; no triangle is flipped, nothing overlaps.",
        lambda v: not v,
    ),
    _Measure(
        "flips",
        "Flipped triangles",
        lambda v: f"{v}",
        "Triangles with inverted orientation on the map; must be 0.",
        lambda v: v > 0,
    ),
    _Measure(
        "angle",
        "Angles",
        _stretch_text,
        "Ratio of largest to smallest stretch: 95th percentile over the skin. ×1: no angle distortion.",
        _stretch_bad,
        "angles",
    ),
    _Measure(
        "area",
        "Areas",
        _stretch_text,
        "Factor by which an area is too large or too small: 95th percentile over the skin. ×1: true size.",
        _stretch_bad,
        "areas",
    ),
    _Measure(
        "edge_error",
        "Local distances",
        _percent,
        "Error of the distances between neighbouring taxels, root mean square at the best scale.",
        lambda v: v > 0.15,
        "local distances",
    ),
    _Measure(
        "torn",
        "Split neighbours",
        _percent,
        "Neighbours on the body that are more than twice as far apart on the map.",
        lambda v: v > 0.05,
        "split neighbours",
    ),
    _Measure(
        "stress",
        "Stress",
        _percent,
        "Stress-1 of the distances between all taxels of a patch against geodesics on the body. 0: none.",
        lambda v: v > 0.5,
        "stress",
    ),
    _Measure(
        "trustworthiness",
        "Trustworthiness",
        lambda v: f"{v:.4f}",
        "1 if the six nearest taxels on the map are nearest on the body too: no false neighbours.",
        lambda v: v < 0.98,
        "false neighbours",
    ),
    _Measure(
        "continuity",
        "Continuity",
        lambda v: f"{v:.4f}",
        "1 if the six nearest taxels on the body are nearest on the map too: no lost neighbours.",
        lambda v: v < 0.95,
        "lost neighbours",
    ),
    _Measure(
        "round_trip_mm",
        "Round-trip error",
        lambda v: f"{_three_digits(v)}\u202fmm",
        "From the body to the map, to a pixel of the image and back: error, 95th percentile over taxels.",
        lambda v: v > 3.0,
        "round-trip error",
    ),
    _Measure(
        "coverage",
        "Coverage",
        _percent,
        "Share of the requested surface that has taxels; Findings say what was left out and why.",
        lambda v: v < LOW_COVERAGE,
        "coverage",
    ),
    _Measure("taxels", "Taxels", lambda v: f"{v}", "Number of tactile elements on the map.", lambda _: False),
)


class _Cell(QWidget):
    """A number, with a mark before it when it is bad."""

    def __init__(self, name: str, parent: QWidget) -> None:
        super().__init__(parent)
        bright = QPalette.ColorRole.BrightText
        self._mark = value_label("", self, right=True, foregroundRole=bright, objectName=f"{name}-mark")
        self._value = value_label("", self, right=True, objectName=name)
        row_layout(self._mark, self._value, parent=self, spacing=2, stretch=self._mark)

    def write(self, text: str, *, bad: bool, best: bool) -> None:
        """Show a value: marked if bad, bold if the better of two."""
        font = self.font()
        font.setBold(best)
        self._value.setFont(font)
        self._value.setText(text)
        self._mark.setText(_MARK if bad else "")


class QualityPanel(Panel):
    """Quality of one map, or of two side by side."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Map quality", "quality-panel", parent)
        self._note = self.caption("Open a robot to measure its map.", "quality-note")
        self._facts: tuple[Mapping[str, Any], ...] = ()
        self._quality: MapQuality | None = None
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        grid.setHorizontalSpacing(8)
        self._heads = [value_label(name, self, right=True, role="caption") for name in "AB"]
        for column, head in enumerate(self._heads, start=1):
            grid.addWidget(head, 0, column)
        self._cells: dict[str, list[_Cell]] = {}
        for number, measure in enumerate(_MEASURES, start=1):
            cells = [_Cell(f"quality-{measure.key}{side}", self) for side in ("", "-b")]
            for column, label in enumerate((value_label(measure.name, self, toolTip=measure.tip), *cells)):
                grid.addWidget(label, number, column)
            self._cells[measure.key] = cells
        self._show_second(False)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the number of taxels of another map until its quality is measured."""
        self._quality = None
        self._show("Measuring…", {"taxels": len(prepared.skin)})

    def show_quality(self, quality: MapQuality) -> None:
        """Show the quality of one map; in a comparison that of the first, until both are compared again."""
        self._quality = quality
        if len(self._facts) == 2:
            self._show("Comparing again…", quality.to_json(), self._facts[1])
        else:
            self.end_comparison()

    def end_comparison(self) -> None:
        """Show the quality of the one map again."""
        if self._quality is not None:
            facts = self._quality.to_json()
            self._show(_verdict(facts), facts)

    def show_comparison(self, comparison: Comparison) -> None:
        """Show two maps of the same taxels side by side; the better number of each row is bold."""
        if isinstance(comparison.first, MapQuality):
            self._quality = comparison.first
        better = {one.name: one.better for one in comparison.measures if one.name in self._cells}
        counts = [sum(side == one for one in better.values()) for side in ("first", "second")]
        self._show(
            f"A is better in {counts[0]} measures, B in {counts[1]}; Procrustes distance "
            f"{comparison.procrustes_mm:.1f}\u202fmm apart.",
            comparison.first.to_json(),
            comparison.second.to_json(),
            better=better,
        )

    def _show_second(self, shown: bool) -> None:
        for label in (*self._heads, *(cells[1] for cells in self._cells.values())):
            label.setVisible(shown)

    def _show(self, note: str, *facts: Mapping[str, Any], better: Mapping[str, str] | None = None) -> None:
        """Show the facts of one map or two, and which of two is better by measure."""
        self._facts = facts
        self._note.setText(note)
        self._show_second(len(facts) == 2)
        for measure in _MEASURES:
            for number, (side, cell) in enumerate(zip(("first", "second"), self._cells[measure.key], strict=True)):
                known = facts[number] if number < len(facts) else {}
                value = known.get(measure.key)
                text = "" if not known else _UNKNOWN if value is None else measure.form(value)
                bad = value is not None and measure.bad(value)
                cell.write(text, bad=bad, best=(better or {}).get(measure.key) == side)
                cell.setToolTip(measure.tip + _details(measure.key, known))


def _details(key: str, facts: Mapping[str, Any]) -> str:
    """Return further facts for the tool tip."""
    value = facts.get(key)
    if key == "torn" and value is not None:
        return f" {facts['torn_pairs']} of {facts['pairs']} pairs."
    if not isinstance(value, Mapping):
        return ""
    median, largest = (f"×{value[name]:.2f}" if value[name] is not None else "∞" for name in ("median", "max"))
    return f" Median {median}, largest {largest}."


def _verdict(facts: Mapping[str, Any]) -> str:
    """Return whether the map is fit for use, or what is wrong with it, in one sentence."""
    if not facts["bijective"]:
        return f"Not bijective: {counted(facts['flips'], 'flipped triangle')}, {counted(facts['overlaps'], 'overlap')}."
    bad = [one.said for one in _MEASURES if one.said and facts[one.key] is not None and one.bad(facts[one.key])]
    return f"Above threshold: {', '.join(bad)}." if bad else "No issues."
