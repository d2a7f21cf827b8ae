"""Edits the controller's path, target and force: settings wanted go out, settings in force come back, with undo and
redo.

A step of ``ControlUndoStack`` changes a few settings and remembers only those: what was turned in the controller panel
in between stays as it is when the step is taken back.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.control.controller_registry import has_task
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.tools.control.drawn_path import DrawnPath

MOST_STEPS = 200


@dataclass(frozen=True)
class ControlStep:
    """One step.

    Attributes:
        name: For people, a verb.
        before: The settings it changed, as they were.
        after: And as they became.
    """

    name: str
    before: dict[str, Any]
    after: dict[str, Any]


class ControlUndoStack:
    """The steps, and where in them we are. Mutable; ``reset`` forgets all."""

    def __init__(self) -> None:
        self._steps: list[ControlStep] = []
        self._position = 0

    def reset(self) -> None:
        """Nothing can be taken back or done again."""
        self._steps = []
        self._position = 0

    @property
    def undo_name(self) -> str:
        """What ``undo`` takes back; empty for nothing."""
        return self._steps[self._position - 1].name if self._position else ""

    @property
    def redo_name(self) -> str:
        """What ``redo`` does again; empty for nothing."""
        return self._steps[self._position].name if self._position < len(self._steps) else ""

    def done(self, name: str, before: ControlSettings, after: ControlSettings, *, goes_on: bool = False) -> None:
        """A step was made; what had been taken back is forgotten. Nothing where nothing changed.

        Args:
            name: For people.
            before: All settings before it.
            after: And after.
            goes_on: Whether it makes one step with the last, where that has its name and changed the same settings.
        """
        names = [f.name for f in fields(after) if getattr(before, f.name) != getattr(after, f.name)]
        if not names:
            return
        step = ControlStep(name, *({known: getattr(each, known) for known in names} for each in (before, after)))
        kept = self._steps[: self._position]
        if goes_on and kept and kept[-1].name == name and kept[-1].before.keys() == step.before.keys():
            step = replace(step, before=kept.pop().before)
        self._steps = [*kept, step][-MOST_STEPS:]
        self._position = len(self._steps)

    def undo(self, settings: ControlSettings) -> ControlSettings:
        """``settings`` without the last step; the same where there is none."""
        if not self._position:
            return settings
        self._position -= 1
        return replace(settings, **self._steps[self._position].before)

    def redo(self, settings: ControlSettings) -> ControlSettings:
        """``settings`` with the step that was taken back last; the same where there is none."""
        if self._position == len(self._steps):
            return settings
        self._position += 1
        return replace(settings, **self._steps[self._position - 1].after)


DEFAULT_CONTROLLER = "hybrid"
"""Taken where the controller in force has no task."""


class ControlSettingsEditor(QObject):
    """Knows the settings in force, and takes back what was drawn. Mutable.

    A gesture changes settings at each move of the mouse and is one step: ``begin``, ``change``, then ``end`` or
    ``cancel``.

    Args:
        parent: Qt parent.

    Attributes:
        settings: In force, as far as was told.
        map: On which is drawn; None before there is one.
        enabled: Whether a session runs that can be led.
        gesture: Name of the gesture that is going on; empty for none.
    """

    wished = Signal(ControlSettings)
    """Use these controller settings."""
    changed = Signal()
    """Settings, map, or what can be taken back are others."""
    told = Signal(str)
    """What a person should know."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.settings = ControlSettings()
        self.enabled = False
        self.gesture = ""
        self.map: TactileMap | None = None
        self._wishes = ControlUndoStack()
        self._before = ControlSettings()

    @property
    def path(self) -> DrawnPath | None:
        """What was drawn; None where a path is in force that nobody drew, or none at all."""
        settings = self.settings
        drawn = has_task(settings.controller) and settings.task == "follow_path" and len(settings.path) > 1
        return DrawnPath(settings.path_kind, settings.path) if drawn else None

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

    def forget_steps(self) -> None:
        """Another session is shown, with settings of its own: what was drawn in the one before has no place there."""
        self._wishes.reset()
        self.changed.emit()

    def set_enabled(self, *, enabled: bool) -> None:
        """Whether there is an arm to lead."""
        self.enabled = enabled
        self.changed.emit()

    # Wishes.

    def do(self, name: str, *, goes_on: bool = False, **changes: Any) -> None:
        """Change settings in one step; a controller without a task makes room for one that has.

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
        self.gesture = name
        self._before = self.settings

    def change(self, **changes: Any) -> None:
        """What the gesture wants so far."""
        controller = self.settings.controller if has_task(self.settings.controller) else DEFAULT_CONTROLLER
        self._wish(replace(self.settings, **{"controller": controller, **changes}))

    def end(self, *, goes_on: bool = False) -> None:
        """The gesture is one step. Nothing without a gesture."""
        name = self.gesture
        self.gesture = ""
        if name:
            self._wishes.done(name, self._before, self.settings, goes_on=goes_on)
            self.changed.emit()

    def cancel(self) -> None:
        """The gesture never was. Nothing without a gesture."""
        name = self.gesture
        self.gesture = ""
        if name:
            self._wish(self._before)

    def clear_path(self) -> None:
        """Forget what was drawn: a path is then laid about the place first touched, and a point held where it is."""
        if self.settings.path:
            self.do("clear the path", controller=self.settings.controller, path=())
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
            self.told.emit(f"Undone: {name}. With other tools Undo takes back edits of the map")

    def redo(self) -> None:
        """Redo the last undone edit of the map last."""
        name = self.redo_name
        if name and self.enabled and not self.gesture:
            self._wish(self._wishes.redo(self.settings))
            self.told.emit(f"Redone: {name}")

    def _wish(self, settings: ControlSettings) -> None:
        if self.enabled and settings != self.settings:
            self.settings = settings
            self.wished.emit(settings)
        self.changed.emit()
