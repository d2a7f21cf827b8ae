"""The simulated skin next to the measured one: the readings that the model expects in this posture, and differences."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import counted
from tactile_maps.live.simulated_skin import SkinDifference
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import SteadyLabel, add_fact, value_label
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.taxel_search import taxel_words
from tactile_widgets.document.taxel_selection import SelectionUpdate
from tactile_widgets.panels.touch.connected_panel import ConnectedPanel
from tactile_widgets.panels.touch.skin_difference_view import SkinDifferenceView
from tactile_widgets.session.live_input import LiveInput

_ROWS = {
    "force": ("Force", "Sum of pressure times area over all taxels: measured, simulated"),
    "rms": ("RMS difference", "Root of the mean squared difference over all taxels"),
    "largest": ("Largest", "The taxel with the largest absolute difference, measured minus simulated"),
}
_UNKNOWN = "–"


class SimulatedSkinPanel(ConnectedPanel):
    """Measured and simulated readings, simulated only while the panel is unfolded.

    Args:
        editor: Editor of the map on which the taxels are laid out.
        parent: Qt parent.

    Attributes:
        view: The three maps.
    """

    enabled_changed = Signal(bool)
    """True if the skin is to be simulated from now on."""

    def __init__(self, editor: MapEditor, parent: QWidget | None = None) -> None:
        super().__init__("Comparison with simulation", "simulated-skin-panel", parent=parent)
        self._editor = editor
        self._found: SkinDifference | None = None
        self._map: TactileMap | None = None
        self._state = self.caption(name="simulated-state", kind=SteadyLabel)
        self.view = SkinDifferenceView(self)
        self.view.pointed.connect(self._on_pointed)
        self.view.chosen.connect(self._on_chosen)
        self.column.addWidget(self.view)
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        self._values = {key: value_label(_UNKNOWN, self, right=True, objectName=f"simulated-{key}") for key in _ROWS}
        for number, (key, (text, tip)) in enumerate(_ROWS.items()):
            add_fact(grid, number, text, tip, self._values[key])
        self._taxel = self.caption(name="simulated-taxel", kind=SteadyLabel)

    def show_input(self, live: LiveInput | None) -> None:
        self._show(None, "" if live is None else _assumptions(live))
        super().show_input(live)

    def show_difference(self, found: SkinDifference) -> None:
        """Show the result of a comparison."""
        if self._input is not None:
            self._show(found, _assumptions(self._input))

    def show_refusal(self, text: str) -> None:
        """Show why the readings cannot be compared."""
        self._show(None, text)

    def set_theme(self, theme: Theme) -> None:
        self.view.set_theme(theme)

    def _on_folded_changed(self) -> None:
        self.enabled_changed.emit(self._input is not None and not self.folded)

    def _show(self, found: SkinDifference | None, text: str) -> None:
        self._found = found
        self._state.setText(text)
        document = self._editor.document
        if document is not None and document.map is not self._map:
            self._map = document.map
            self.view.show_map(self._map)
        self.view.show_difference(found)
        for key, words in self._texts(found).items():
            self._values[key].setText(words)
        self._on_pointed()

    def _texts(self, found: SkinDifference | None) -> dict[str, str]:
        if found is None or self._map is None:
            return dict.fromkeys(_ROWS, _UNKNOWN)
        skin = self._map.skin
        worst = int(np.argmax(np.abs(found.difference)))
        return {
            "force": f"{_force(skin, found.measured):.2f}, {_force(skin, found.simulated):.2f}\u202fN",
            "rms": f"{1e-3 * found.rms:.2f}\u202fkPa",
            "largest": f"{_signed(found.difference[worst])} at {taxel_words(skin, worst)}",
        }

    def _on_pointed(self) -> None:
        """Show the readings of the taxel under the pointer."""
        taxel = self.view.hovered
        found = self._found
        text = "Point at a taxel to read it, click to select it."
        if taxel is not None and found is not None and self._map is not None and taxel < len(found.measured):
            values = f"measured {1e-3 * found.measured[taxel]:.2f}, simulated {1e-3 * found.simulated[taxel]:.2f}"
            name = capitalized(taxel_words(self._map.skin, taxel))
            text = f"{name}: {values}, difference {_signed(found.difference[taxel])}"
        self._taxel.setText(text)

    def _on_chosen(self, taxel: int) -> None:
        self._selection.take(SelectionUpdate(np.array([taxel]), SelectionMode.REPLACE))


def _force(skin: Skin, pressures: FloatArray) -> float:
    return float(pressures @ skin.areas)


def _signed(pascals: float) -> str:
    return f"{1e-3 * pascals:+.2f}\u202fkPa".replace("-", "−")


def _assumptions(live: LiveInput) -> str:
    """Return which bodies press the simulated skin, and its posture."""
    names = ", ".join(body.spec.name for body in live.origin.objects)
    objects = f"and by objects at their places at the start of the scene: {names}"
    pressed = objects if names else "alone: there are no objects"
    facts, _silent = live.facts()
    rest = f" At rest: {counted(facts.unheard_joints, 'joint')} without a position." if facts.unheard_joints else ""
    return f"In the simulation the skin is pressed by the robot itself {pressed}.{rest}"
