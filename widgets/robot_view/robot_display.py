"""The robot, and what is said instead of it: empty, loading, failed. Where its taxels are, and its way to the map.

``MorphSlider`` lays the skin flat: body at its left end, map at its right.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QPropertyAnimation, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSlider, QWidget

from app.core.arrays import BoolArray, FloatArray, IntArray
from app.session.prepare import PreparedScene
from widgets.common.colours import PressureScale, Theme
from widgets.common.placeholder_card import PlaceholderCard
from widgets.robot_view.body_layer import BodyLayerFactory
from widgets.robot_view.picking import BodyTaxels, SkinPicker, facing_pixels
from widgets.robot_view.robot_canvas import RobotCanvas

STEPS = 100
EASE_MS = 150
_WIDTH, _HEIGHT = 190, 24


class MorphSlider(QWidget):
    """A small slider between two words; ``toggle`` goes from one end to the other so that the eye can follow."""

    moved = Signal(float)
    """The share of flatness asked for, from 0 to 1."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("morph")
        self.slider = QSlider(Qt.Orientation.Horizontal, self)
        self.slider.setRange(0, STEPS)
        self.slider.setAccessibleName("Flatten: body to map")
        self.slider.setToolTip("Flatten the skin with the pressures on it; each point moves straight to the map (M)")
        self.slider.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.slider.valueChanged.connect(self._on_value_changed)
        row = QHBoxLayout(self)
        row.setContentsMargins(6, 0, 6, 0)
        row.setSpacing(6)
        for part in (QLabel("Body", self), self.slider, QLabel("Map", self)):
            part.setProperty("role", "caption")
            row.addWidget(part)
        self._ease = QPropertyAnimation(self.slider, b"value", self)
        self._ease.setDuration(EASE_MS)
        self.resize(_WIDTH, _HEIGHT)
        self.hide()

    @property
    def share(self) -> float:
        """How flat: 0 on the body, 1 as on the map."""
        return self.slider.value() / STEPS

    def toggle(self) -> None:
        """To the other end, from wherever it is."""
        self._ease.stop()
        self._ease.setStartValue(self.slider.value())
        self._ease.setEndValue(STEPS if self.share < 0.5 else 0)
        self._ease.start()

    def reset(self) -> None:
        """On the body, at once."""
        self._ease.stop()
        self.slider.setValue(0)

    def _on_value_changed(self, _value: int) -> None:
        self.moved.emit(self.share)


_CUBE_ROOM = 78
"""Width that the orientation cube takes in the lower right corner [px]."""


class RobotDisplay(RobotCanvas):
    """Shows one prepared robot, or says why there is none. Knows no hand.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Makes each layer that has actors, by name.
    """

    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, BodyLayerFactory] | None = None,
    ) -> None:
        super().__init__(theme, scale, parent, layers=layers)
        self._picker: SkinPicker | None = None
        self._taxels: BodyTaxels | None = None
        self._loading = False
        self.morph = MorphSlider(self)
        self.morph.moved.connect(self._on_morphed)
        self._card = PlaceholderCard(self)
        self._card.helped.connect(self._on_card_helped)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the robot of ``prepared`` at home, framed; if it cannot be, the last one stays."""
        picker = SkinPicker(prepared)
        self.morph.reset()
        self._card.hide()
        self.show_robot(prepared)
        self.morph.show()
        self._picker, self._taxels = picker, BodyTaxels(prepared, picker)

    def show_empty(self) -> None:
        """Say what would fill the view."""
        text = "Open a robot, or drop its file here: MJCF, URDF or a bare mesh."
        self._show_card("No robot yet", text, button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a robot is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._show_card("Preparing the robot", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no robot."""
        self._show_card("The robot could not be opened", text, button="Open robot…")

    def show_last(self) -> None:
        """Go back to the last good robot after loading another one failed or was cancelled."""
        if self.prepared is None:
            self.show_empty()
        else:
            self._card.hide()
            self.request()

    def close_view(self) -> None:
        """Give the graphics back; the view draws nothing after this."""
        self._picker = self._taxels = None
        super().close_view()

    def _show_card(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._loading = progress is not None
        self._card.setGeometry(self.rect())
        self._card.say(heading, text, button=button, progress=progress)

    def _on_card_helped(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()

    def request(self, *, moving: bool = False) -> None:
        """Draw soon, unless a message covers the view."""
        if not self._card.isVisible():
            super().request(moving=moving)

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) where those are that face the eye [px]; NaN for the others."""
        if self._taxels is None:
            return np.zeros((0, 2))
        size = (self.width(), self.height())
        if self.scene.morphed:
            return facing_pixels(*self.scene.flat_taxels(), self.scene.viewpoint, size)
        return self._taxels.pixels(self.scene.viewpoint, size, self.scene.poses)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """(k,) which of these the robot itself, or an object, hides; off the body, nothing hides what faces the eye."""
        if self._taxels is None or self.scene.morphed:
            return np.zeros(len(taxels), bool)
        return self._taxels.hidden(taxels, self.scene.viewpoint, self.scene.body_poses)

    def _on_morphed(self, share: float) -> None:
        self.scene.morph(share)
        self.request(moving=True)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: the message keeps covering the view."""
        super().resizeEvent(event)
        self._card.setGeometry(self.rect())
        self.morph.move(self.width() - self.morph.width() - _CUBE_ROOM, self.height() - self.morph.height() - 11)
