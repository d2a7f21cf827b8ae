"""Fingers on the skin: presses, strokes and releases on either view, and fingers that stay until they are removed."""

from __future__ import annotations

from PySide6.QtCore import QObject

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel


class TouchPresenter(QObject):
    """Passes touches from the gestures on both views to the session.

    Args:
        context: Session, views and panels.
        parent: Qt parent.
    """

    def __init__(self, context: AppContext, parent: QObject) -> None:
        super().__init__(parent)
        self._context = context
        self._session = context.session
        self.fingers = context.panels.get(ContactsPanel).fingers
        for gestures in context.views.interactions:
            gestures.poke_pressed.connect(self.press)
            gestures.poke_moved.connect(self._session.move)
            gestures.poke_released.connect(self._session.release)
            gestures.latch_requested.connect(self.hold)

    def press(self, at: SurfacePoint) -> None:
        """Press the skin with the user's finger."""
        if self._can_touch():
            self._session.press(at)

    def hold(self, at: SurfacePoint) -> None:
        """Press the skin with a finger that stays."""
        if self._can_touch():
            self._session.hold_finger(at, self.fingers.held.value())

    def _can_touch(self) -> bool:
        """Whether the current session accepts touches. If not, report why and offer a remedy."""
        session = self._session
        notifier = self._context.notifier
        actions = self._context.actions
        if session.player is not None:
            notifier.say("This is a recording: it cannot be pressed.", remedies=[actions["take_over"]])
            return False
        if session.simulating and session.source is not None and not session.source.settings.effects.fingers:
            notifier.say("No finger is simulated in this scene.", remedies=[actions["simulate_fingers"]])
            return False
        return True
