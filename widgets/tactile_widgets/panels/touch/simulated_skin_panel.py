"""The simulated skin beside the measured one: what the model expects in this posture, and where the skin disagrees."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QLabel, QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.live.simulated_skin import SkinDifference
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.panel import Panel, value_label
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.taxel_search import taxel_words
from tactile_widgets.document.taxel_selection import SelectionUpdate, TaxelSelection
from tactile_widgets.panels.touch.skin_difference_view import SkinDifferenceView
from tactile_widgets.session.live_input import LiveInput

_ROWS = {
    "force": ("Force", "Sum of pressure times area over all taxels: measured, simulated"),
    "rms": ("RMS difference", "Root of the mean squared difference over all taxels"),
    "largest": ("Largest", "The taxel at which measured minus simulated is largest by amount"),
}
_UNKNOWN = "–"


class SimulatedSkinPanel(Panel):
    """Hidden while nothing is connected; simulates only while it is unfolded.

    Args:
        editor: Of the map, by which the taxels are laid out.
        parent: Qt parent.

    Attributes:
        view: The three maps.
    """

    wanted = Signal(bool)
    """Whether the simulated skin is wanted from now on."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("Comparison with simulation", "simulated-skin-panel", parent)
        self._editor = editor
        self._input: LiveInput | None = None
        self._selection: TaxelSelection | None = None
        self._found: SkinDifference | None = None
        self._map: TactileMap | None = None
        self._told = self.caption()
        self._told.setObjectName("simulated-told")
        self.view = SkinDifferenceView(self)
        self.view.pointed.connect(self._on_pointed)
        self.view.chosen.connect(self._on_chosen)
        self.column.addWidget(self.view)
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        self._values: dict[str, QLabel] = {}
        for row, (key, (text, tip)) in enumerate(_ROWS.items()):
            name = value_label(text, self)
            value = value_label(_UNKNOWN, self, right=True)
            name.setToolTip(tip)
            value.setObjectName(f"simulated-{key}")
            grid.addWidget(name, row, 0)
            grid.addWidget(value, row, 1)
            self._values[key] = value
        self._taxel = self.caption()
        self._taxel.setObjectName("simulated-taxel")
        self.folded_changed.connect(self._tell_wanted)
        self.hide()

    def follow(self, selection: TaxelSelection) -> None:
        """What is clicked here is selected there."""
        self._selection = selection

    def show_input(self, live: LiveInput | None) -> None:
        """Another live input is shown; None for none."""
        self._input = live
        self.setVisible(live is not None)
        self._show(None, "" if live is None else _assumed(live))
        self._tell_wanted()

    def set_folded(self, folded: bool) -> None:
        """Fold or unfold it without telling a person's hand; what is folded is not simulated."""
        super().set_folded(folded)
        self._tell_wanted()

    def show_difference(self, found: SkinDifference) -> None:
        """Show what was compared."""
        if self._input is not None:
            self._show(found, _assumed(self._input))

    def show_refusal(self, text: str) -> None:
        """Say why nothing can be compared."""
        self._show(None, text)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.view.set_theme(theme)

    def _tell_wanted(self) -> None:
        self.wanted.emit(self._input is not None and not self.folded)

    def _show(self, found: SkinDifference | None, text: str) -> None:
        self._found = found
        self._told.setText(text)
        document = self._editor.document
        if document is not None and document.map is not self._map:
            self._map = document.map
            self.view.show_map(self._map)
        self.view.show_difference(found)
        for key, words in self._texts(found).items():
            self._values[key].setText(words)
        self._taxel.setText(self._taxel_text())

    def _texts(self, found: SkinDifference | None) -> dict[str, str]:
        if found is None or self._map is None:
            return dict.fromkeys(_ROWS, _UNKNOWN)
        skin = self._map.skin
        worst = int(np.argmax(np.abs(found.difference)))
        measured = _force(skin, found.measured)
        simulated = _force(skin, found.simulated)
        return {
            "force": f"{measured:.2f}, {simulated:.2f}\u202fN",
            "rms": f"{1e-3 * found.rms:.2f}\u202fkPa",
            "largest": f"{_signed(found.difference[worst])} at {taxel_words(skin, worst)}",
        }

    def _taxel_text(self) -> str:
        """Of the taxel under the pointer."""
        taxel = self.view.hovered
        found = self._found
        if taxel is None or found is None or self._map is None or taxel >= len(found.measured):
            return "Point at a taxel to read it, click to select it."
        values = f"measured {1e-3 * found.measured[taxel]:.2f}, simulated {1e-3 * found.simulated[taxel]:.2f}"
        name = taxel_words(self._map.skin, taxel)
        return f"{name[0].upper()}{name[1:]}: {values}, difference {_signed(found.difference[taxel])}"

    def _on_pointed(self, _taxel: int | None) -> None:
        self._taxel.setText(self._taxel_text())

    def _on_chosen(self, taxel: int) -> None:
        if self._selection is not None:
            self._selection.take(SelectionUpdate(np.array([taxel]), SelectionMode.REPLACE))


def _force(skin: Skin, pressures: FloatArray) -> float:
    return float(pressures @ skin.areas)


def _signed(pascals: float) -> str:
    return f"{1e-3 * pascals:+.2f}\u202fkPa".replace("-", "−")


def _assumed(live: LiveInput) -> str:
    """What presses the simulated skin, and in which posture."""
    names = ", ".join(body.spec.name for body in live.origin.objects)
    objects = f"and by objects where the scene has them at its start: {names}"
    pressed = objects if names else "alone: there are no objects"
    facts, _silent = live.facts()
    rest = f" {facts.unheard_joints} joints without a position stand at rest." if facts.unheard_joints else ""
    return f"In the simulation the skin is pressed by the robot itself {pressed}.{rest}"
