"""The robot, and what is said instead of it: empty, loading, failed. Where its taxels are, and its way to the map."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QWidget

from app.arrays import BoolArray, FloatArray, IntArray
from app.session.prepare import Prepared
from widgets.colours import PressureScale, Theme
from widgets.robot_view.body_taxels import BodyTaxels, facing_pixels
from widgets.robot_view.morph_slider import MorphSlider
from widgets.robot_view.pick import SkinPicker
from widgets.robot_view.robot_canvas import RobotCanvas
from widgets.state_card import StateCard

_CUBE_ROOM = 78
"""Width that the orientation cube takes in the lower right corner [px]."""


class RobotDisplay(RobotCanvas):
    """Shows one prepared robot, or says why there is none. Knows no hand.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
    """

    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(theme, scale, parent)
        self._picker: SkinPicker | None = None
        self._taxels: BodyTaxels | None = None
        self._loading = False
        self.morph = MorphSlider(self)
        self.morph.moved.connect(self._on_morphed)
        self._card = StateCard(self)
        self._card.helped.connect(self._on_card_helped)

    def show_prepared(self, prepared: Prepared) -> None:
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
        self._tell("No robot yet", text, button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a robot is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._tell("Preparing the robot", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no robot."""
        self._tell("The robot could not be opened", text, button="Open robot…")

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

    def _tell(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
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
