"""The one whom tools ask where the arm is to go: settings wanted go out, settings in force come back."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtCore import QObject, Signal

from app.control.command import ControlSettings
from app.control.laws import RULES
from app.maps.tactile_map import TactileMap
from widgets.control_tools.path_shape import PathShape
from widgets.control_tools.wishes import Wishes

USUAL_LAW = "hybrid"
"""Taken where the law in force has no task."""


class Lead(QObject):
    """Knows the settings in force, and takes back what was drawn. Mutable.

    A gesture changes settings at each move of the hand and is one step: ``begin``, ``change``, then ``end`` or
    ``cancel``.

    Args:
        parent: Qt parent.

    Attributes:
        settings: In force, as far as was told.
        map: On which is drawn; None before there is one.
        enabled: Whether a session runs that can be led.
        gesture: Name of the gesture that is going on; empty for none.
    """

    wished = Signal(object)
    """ControlSettings wanted."""
    changed = Signal()
    """Settings, map, or what can be taken back are others."""
    told = Signal(str)
    """What a person should know."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.settings, self.enabled, self.gesture = ControlSettings(), False, ""
        self.map: TactileMap | None = None
        self._wishes, self._before = Wishes(), ControlSettings()

    @property
    def path(self) -> PathShape | None:
        """What was drawn; None where a path is in force that nobody drew, or none at all."""
        settings = self.settings
        drawn = settings.law in RULES and settings.task == "follow_path" and len(settings.path) > 1
        return PathShape(settings.path_kind, settings.path) if drawn else None

    @property
    def undo_name(self) -> str:
        """What ``undo`` takes back; empty for nothing."""
        return self._wishes.undo_name

    @property
    def redo_name(self) -> str:
        """What ``redo`` does again; empty for nothing."""
        return self._wishes.redo_name

    # Facts.

    def show_settings(self, settings: ControlSettings) -> None:
        """These are in force."""
        self.settings = settings
        self.changed.emit()

    def show_map(self, map_: TactileMap) -> None:
        """Drawn on this map from now on; on another skin, nothing can be taken back."""
        if self.map is None or map_.skin is not self.map.skin:
            self._wishes.reset()
        self.map = map_
        self.changed.emit()

    def set_enabled(self, *, enabled: bool) -> None:
        """Whether there is an arm to lead."""
        self.enabled = enabled
        self.changed.emit()

    # Wishes.

    def do(self, name: str, *, goes_on: bool = False, **changes: Any) -> None:
        """Change settings in one step; a law without a task makes room for one that has.

        Args:
            name: Of the step, a verb.
            goes_on: Whether it makes one step with the last, where that was of its kind.
            changes: New values, by name.
        """
        self.begin(name)
        self.change(**changes)
        self.end(goes_on=goes_on)

    def begin(self, name: str) -> None:
        """A gesture starts; one that goes on has ended."""
        self.end()
        self.gesture, self._before = name, self.settings

    def change(self, **changes: Any) -> None:
        """What the gesture wants so far."""
        law = self.settings.law if self.settings.law in RULES else USUAL_LAW
        self._wish(replace(self.settings, **{"law": law, **changes}))

    def end(self, *, goes_on: bool = False) -> None:
        """The gesture is one step. Nothing without a gesture."""
        name, self.gesture = self.gesture, ""
        if name:
            self._wishes.done(name, self._before, self.settings, goes_on=goes_on)
            self.changed.emit()

    def cancel(self) -> None:
        """The gesture never was. Nothing without a gesture."""
        name, self.gesture = self.gesture, ""
        if name:
            self._wish(self._before)

    def clear_path(self) -> None:
        """Forget what was drawn: a path is then laid about the place first touched, and a point held where it is."""
        if self.settings.path:
            self.do("clear the path", law=self.settings.law, path=())
        else:
            self.told.emit("There is no path to clear")

    def undo(self) -> None:
        """Take back the last step, or the gesture that is going on."""
        if self.gesture:
            self.cancel()
            return
        name = self.undo_name
        if name and self.enabled:
            self._wish(self._wishes.undo(self.settings))
            self.told.emit(f"Taken back: {name}. With other tools Ctrl+Z takes back edits of the map")

    def redo(self) -> None:
        """Do again what was taken back last."""
        name = self.redo_name
        if name and self.enabled and not self.gesture:
            self._wish(self._wishes.redo(self.settings))
            self.told.emit(f"Done again: {name}")

    def _wish(self, settings: ControlSettings) -> None:
        if self.enabled and settings != self.settings:
            self.settings = settings
            self.wished.emit(settings)
        self.changed.emit()
