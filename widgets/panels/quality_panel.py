"""How good the map is, at one look."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from app.maps.quality import MapQuality
from app.session.prepare import Prepared
from widgets.panels.panel import Panel, fact

_ROWS = (
    # key, text, format, tool tip
    ("patches", "Patches", "{:d}", "Pieces of skin laid flat"),
    ("taxels", "Taxels", "{:d}", "Tactile elements on the map"),
    ("flips", "Flipped triangles", "{:d}", "Must be 0"),
    ("bijective", "One-to-one", "{}", "Every map point has one body point and back"),
    ("symmetric_dirichlet", "Distortion", "{:.3f}", "Mean symmetric Dirichlet energy; 4 is none"),
    ("edge_error", "Neighbour distance error", "{:.1%}", "Root mean square, between neighbouring taxels"),
    ("trustworthiness", "Trustworthiness", "{:.4f}", "1: who is close on the map is close on the body"),
    ("continuity", "Continuity", "{:.4f}", "1: who is close on the body is close on the map"),
    ("round_trip_mm", "Round trip", "{:.2f}\u2009mm", "Body to map to pixel and back, 95th percentile"),
)


class QualityPanel(Panel):
    """The quality card."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Map quality", "quality-panel", parent)
        self._note = self.caption("Open a robot to measure its map.")
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        self._values = {}
        for row, (key, text, _, tip) in enumerate(_ROWS):
            name, value = fact(text, self), fact("", self, right=True)
            value.setObjectName(f"quality-{key}")
            for column, label in enumerate((name, value)):
                label.setToolTip(tip)
                grid.addWidget(label, row, column)
            self._values[key] = value

    def show_prepared(self, prepared: Prepared) -> None:
        """Another map; its quality comes a moment later."""
        self._note.setText("Measuring…")
        self._note.show()
        for value in self._values.values():
            value.setText("")
        self._values["patches"].setText(str(len(prepared.skin.patches)))
        self._values["taxels"].setText(str(len(prepared.skin)))

    def show_quality(self, quality: MapQuality) -> None:
        """The numbers."""
        self._note.hide()
        facts = quality.to_json()
        for key, _, form, _ in _ROWS:
            value = facts[key]
            text = (
                {True: "yes", False: "no"}[value]
                if isinstance(value, bool)
                else form.format(value).replace("%", "\u2009%")
            )
            self._values[key].setText(text)
