"""Fingers on the skin: presses, strokes and releases on either view, and fingers that stay until they are removed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.tactile.poke import PokeMoved, PokePressed, PokePulled, PokeReleased
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.context.presenter import Presenter
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel

MOUSE_FINGER = 1
"""Id of the mouse's finger; scripted fingers have 0 and below, fingers that stay 2 and above."""


@dataclass(frozen=True)
class _Refusal:
    """Reason why the skin cannot be pressed, and actions that help; for ``pending`` see ``Message``."""

    text: str
    remedies: Sequence[QAction] = ()
    pending: Callable[[], bool] | None = None


class TouchPresenter(Presenter):
    """Passes touches from the gestures on both views, and from the panel of fingers, to the session.

    Args:
        context: Session, views and panels.
        parent: Window over which dialogs open.

    Attributes:
        fingers: Panel of the mouse's finger and of those that stay.
    """

    touched = Signal()
    """The user touched the skin."""

    def __init__(self, context: AppContext, parent: QWidget) -> None:
        super().__init__(context, parent)
        self._last_id = MOUSE_FINGER
        self._explained = ""  # why what is shown cannot be pressed
        self.fingers = context.panels.get(ContactsPanel).fingers
        self.fingers.force_edited.connect(self.set_force)
        self.fingers.removed.connect(self.remove)
        self._session.replay.player_changed.connect(self._forget_explanation)
        self._session.connection.changed.connect(self._forget_explanation)
        for gestures in context.views.interactions:
            gestures.poke_pressed.connect(self.press)
            gestures.poke_moved.connect(self.move)
            gestures.poke_pulled.connect(self.pull)
            gestures.poke_released.connect(self.release)
            gestures.latch_requested.connect(self.hold)

    def press(self, at: SurfacePoint) -> None:
        """Press the skin with the mouse's finger."""
        if self._can_touch() and self._session.submit(PokePressed(MOUSE_FINGER, at, self.fingers.finger)):
            self.touched.emit()

    def move(self, at: SurfacePoint) -> None:
        """Move the mouse's finger along the skin."""
        if self.fingers.drags.isChecked():
            self.pull(at)
        else:
            self._session.submit(PokeMoved(MOUSE_FINGER, at))

    def pull(self, at: SurfacePoint) -> None:
        """Pull the mouse's finger along the skin, which it drags by friction."""
        self._session.submit(PokePulled(MOUSE_FINGER, at))

    def release(self) -> None:
        """Lift the mouse's finger."""
        self._session.submit(PokeReleased(MOUSE_FINGER))

    def hold(self, at: SurfacePoint) -> None:
        """Press with another finger, which stays until it is removed or the scene restarts."""
        frame = self._session.shown
        used = () if frame is None else (poke.id for poke in frame.pokes)
        if self._can_touch():
            self._last_id = max([self._last_id, *used]) + 1
            finger = replace(self.fingers.finger, max_force=self.fingers.held.value())
            if self._session.submit(PokePressed(self._last_id, at, finger)):
                self.touched.emit()

    def set_force(self, finger_id: int, force: float) -> None:
        """Let a finger that stays press with another force [N] where it is."""
        frame = self._session.shown
        for poke in () if frame is None else frame.pokes:
            if poke.id == finger_id:
                self._session.submit(PokePressed(finger_id, poke.at, replace(self.fingers.finger, max_force=force)))

    def remove(self, finger_id: int) -> None:
        """Lift a finger that stays."""
        self._session.submit(PokeReleased(finger_id))

    def _can_touch(self) -> bool:
        """Whether touches are accepted. If not, report why: in a message once, then in the status line."""
        refusal = self._refusal()
        if refusal is None:
            self._explained = ""
            return True
        if refusal.text == self._explained:
            self._notifier.status(refusal.text)
        else:
            self._notifier.say(refusal.text, remedies=refusal.remedies, pending=refusal.pending)
        self._explained = refusal.text
        return False

    def _refusal(self) -> _Refusal | None:
        """Return why the skin cannot be pressed, which is never a failure; None if it can."""
        session = self._session
        actions = self._context.actions
        if (player := session.replay.player) is not None:
            text = "This is a recording: it cannot be pressed."
            if player.measured is None:
                return _Refusal(text, [actions["take_over"]])
            return _Refusal(f"{text} Its readings are those of a real skin, which no simulation continues.")
        if session.live_input is not None:
            return _Refusal("A real skin is connected: it cannot be pressed here.", [actions["disconnect"]])
        if self._lacks_fingers:
            text = "No finger is simulated in this scene."
            return _Refusal(text, [actions["simulate_fingers"]], pending=lambda: self._lacks_fingers)
        return None

    def _forget_explanation(self, _changed: object) -> None:
        self._explained = ""

    @property
    def _lacks_fingers(self) -> bool:
        """Whether a simulation without fingers is shown."""
        run = self._session.shown_run
        return self._session.simulating and run is not None and not run.settings.effects.fingers
