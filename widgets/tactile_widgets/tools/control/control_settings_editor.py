"""Editor of the controller's path, target and force: emits requested settings and receives the current ones, with undo.

A step of ``ControlUndoStack`` stores only the settings that it changes: undoing it does not revert settings changed in
the controller panel in the meantime.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any, TypedDict, Unpack

from PySide6.QtCore import QObject, Signal

from tactile_maps.control.controller_registry import has_task
from tactile_maps.control.motion.command import ControlSettings, TaskName
from tactile_maps.editing.history import Step
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.path_on_body import Points
from tactile_maps.maps.paths import PathKind
from tactile_widgets.document.skin_steps import ControlStep, StepsOnSkin
from tactile_widgets.document.step_list import StepList
from tactile_widgets.tools.control.carried_paths import CarriedPaths, path_on_skin
from tactile_widgets.tools.control.drawn_path import DrawnPath

MOST_STEPS = 200


class SettingChanges(TypedDict, total=False):
    """Settings that tools change; a misspelt name is an error of types and not one while the mouse moves."""

    controller: str
    force_goal: float
    path: tuple[tuple[float, float], ...]
    path_kind: PathKind
    task: TaskName


def _values(settings: ControlSettings, names: Sequence[str]) -> dict[str, Any]:
    return {name: getattr(settings, name) for name in names}


Carry = Callable[[PathKind, Points], tuple[PathKind, Points]]
"""Returns kind and points of a path on another map."""


def _with_path(values: dict[str, Any], kind: PathKind, carry: Carry) -> dict[str, Any]:
    """Return values of a step with its path on another map; ``kind`` is that of the path if the step has none."""
    if "path" not in values:
        return values
    kind = values.get("path_kind", kind)
    carried, path = carry(kind, values["path"])
    return {**values, "path": path, **({} if carried == kind else {"path_kind": carried})}


def _carried(step: ControlStep, kind: PathKind, carry: Carry) -> ControlStep:
    return replace(step, before=_with_path(step.before, kind, carry), after=_with_path(step.after, kind, carry))


class ControlUndoStack(StepList[dict[str, Any]]):
    """Undo steps with the previous and new values of the settings that each changes, by name. Mutable."""

    def __init__(self) -> None:
        super().__init__(MOST_STEPS)
        self._oldest = 0  # steps with lower numbers were discarded

    def reset(self) -> None:
        super().reset()
        self._oldest = Step("").number

    def done(self, name: str, before: ControlSettings, after: ControlSettings, *, extend: bool = False) -> None:
        """Add a step unless nothing changed; undone steps are discarded.

        Args:
            name: Name shown to the user.
            before: All settings before the step.
            after: All settings after it.
            extend: Whether to merge it with the last step if that has the same name and changed the same settings.
        """
        names = [f.name for f in fields(after) if getattr(before, f.name) != getattr(after, f.name)]
        if names:
            same = self._position > 0 and [*self._steps[self._position - 1].before] == names
            self.push(name, _values(before, names), _values(after, names), extend=extend and same)

    def carry(self, kind: PathKind, carry: Carry) -> None:
        """Carry the paths of all steps to another map.

        Args:
            kind: Shape of paths whose step did not choose one.
            carry: Returns a path on the other map.
        """
        self._steps = [_carried(step, kind, carry) for step in self._steps]

    def leave_skin(self, map_: TactileMap) -> StepsOnSkin:
        """Return the steps with their values on the current map."""
        numbers = tuple(step.number for step in self.done_steps)
        return StepsOnSkin(map_, {step.number: step for step in self._steps}, numbers)

    def enter_skin(self, left: StepsOnSkin, kind: PathKind, carry: Carry) -> None:
        """Replace the values of the steps by those on another skin.

        Args:
            left: The steps when that skin was left; the steps that were added since are carried.
            kind: Shape of paths whose step did not choose one.
            carry: Returns a path on the map of the other skin.
        """
        self._steps = [left.steps.get(step.number) or _carried(step, kind, carry) for step in self._steps]

    def settings_on_skin(self, left: StepsOnSkin, settings: ControlSettings, carry: Carry) -> ControlSettings:
        """Return the settings on a skin that is shown again: as it was left, except for steps undone or made since.

        Args:
            left: The steps when that skin was left.
            settings: The settings when it was left.
            carry: Returns a path on the map of that skin.
        """
        done = self.done_steps
        still_done = {step.number for step in done}
        oldest = self._steps[0].number if len(self._steps) == MOST_STEPS else self._oldest
        for number in reversed(left.done):
            if number >= oldest and number not in still_done:
                settings = replace(settings, **left.steps[number].before)
        for step in done:
            if step.number not in left.done:
                after = (left.steps.get(step.number) or _carried(step, settings.path_kind, carry)).after
                settings = replace(settings, **after)
        return settings

    def undo(self, settings: ControlSettings) -> ControlSettings:
        """Return ``settings`` without the last step; unchanged if there is none."""
        return replace(settings, **self.back()) if self.undo_step.number else settings

    def redo(self, settings: ControlSettings) -> ControlSettings:
        """Return ``settings`` with the last undone step; unchanged if there is none."""
        return replace(settings, **self.forward()) if self.redo_step.number else settings


DEFAULT_CONTROLLER = "hybrid"
"""Controller that is chosen if the current one has no task."""


class ControlSettingsEditor(QObject):
    """Editor of the current settings with undo of drawn changes. Mutable.

    A gesture changes settings at each mouse move and forms one step: ``begin``, ``change``, then ``end`` or ``cancel``.

    Args:
        parent: Qt parent.

    Attributes:
        settings: Last known current settings.
        map: Map on which the user draws; None before there is one.
        enabled: Whether a session runs whose arm can be controlled.
        gesture: Name of the current gesture; empty if there is none.
        steps: Steps that can be undone or redone.
    """

    settings_requested = Signal(ControlSettings)
    """The user requested these controller settings."""
    changed = Signal()
    """Settings, map or undo steps changed."""
    notified = Signal(str)
    """Message for the user."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.settings = ControlSettings()
        self.enabled = False
        self.gesture = ""
        self.map: TactileMap | None = None
        self.steps = ControlUndoStack()
        self._before = ControlSettings()
        self._carried = CarriedPaths()

    @property
    def path(self) -> DrawnPath | None:
        """Drawn path; None if the current path was not drawn, or without a path."""
        settings = self.settings
        drawn = has_task(settings.controller) and settings.task == "follow_path" and len(settings.path) > 1
        return DrawnPath(settings.path_kind, settings.path) if drawn else None

    # State of the session.

    def show_settings(self, settings: ControlSettings) -> None:
        """Set the current settings."""
        self.settings = settings
        self.changed.emit()

    def show_map(self, map_: TactileMap) -> None:
        """Set the map on which the user draws."""
        self.map = map_
        self.changed.emit()

    def leave_skin(self) -> StepsOnSkin:
        """Return the steps with their values on the current map."""
        assert self.map is not None
        return self.steps.leave_skin(self.map)

    def enter_skin(self, left: StepsOnSkin) -> None:
        """Set another skin, on which the steps keep their places on the body; ``left`` has those known there."""
        self.steps.enter_skin(left, self.settings.path_kind, self._to_skin(left.map))
        self.map = left.map

    def settings_on(self, left: StepsOnSkin, settings: ControlSettings) -> ControlSettings:
        """Return the settings with which an earlier skin is shown again.

        Args:
            left: The steps when that skin was left.
            settings: Settings when it was left; steps that were undone or made since change them.
        """
        return self.steps.settings_on_skin(left, settings, self._to_skin(left.map))

    def _to_skin(self, after: TactileMap) -> Carry:
        before = self.map
        assert before is not None
        return lambda kind, path: (kind, path_on_skin(path, before, after))

    def carry_path(self, settings: ControlSettings, before: TactileMap, after: TactileMap) -> ControlSettings:
        """Return settings whose path or target is at the same place on the body after an edit of the map.

        The paths of the undo steps and of the current gesture are carried as well.
        """
        carry = partial(self._carried.carry, before=before, after=after)
        self.steps.carry(settings.path_kind, carry)
        kind, path = carry(self._before.path_kind, self._before.path)
        self._before = replace(self._before, path_kind=kind, path=path)
        kind, path = carry(settings.path_kind, settings.path)
        return replace(settings, path_kind=kind, path=path)

    def forget_steps(self) -> None:
        """Discard all undo steps, because another session has its own settings."""
        self.steps.reset()
        self.changed.emit()

    def set_enabled(self, *, enabled: bool) -> None:
        """Set whether a session runs whose arm can be controlled."""
        self.enabled = enabled
        self.changed.emit()

    # Requests of the user.

    def do(self, name: str, *, extend: bool = False, **changes: Unpack[SettingChanges]) -> None:
        """Change settings in one step; a controller without a task is replaced by one that has a task.

        Args:
            name: Name of the step, a verb.
            extend: Whether to merge it with the last step if that is of the same kind.
            changes: New values by name.
        """
        self.begin(name)
        self.change(**changes)
        self.end(extend=extend)

    def begin(self, name: str) -> None:
        """Start a gesture, ending any current one."""
        self.end()
        self.gesture = name
        self._before = self.settings

    def change(self, **changes: Unpack[SettingChanges]) -> None:
        """Request the settings of the gesture so far."""
        controller = self.settings.controller if has_task(self.settings.controller) else DEFAULT_CONTROLLER
        changed: dict[str, Any] = {"controller": controller, **changes}
        self._request(replace(self.settings, **changed))

    def end(self, *, extend: bool = False) -> None:
        """End the gesture as one step. Does nothing without a gesture."""
        name = self.gesture
        self.gesture = ""
        if name:
            self.steps.done(name, self._before, self.settings, extend=extend)
            self._before = ControlSettings()
            self.changed.emit()

    def cancel(self) -> None:
        """Cancel the gesture and restore the settings before it. Does nothing without a gesture."""
        name = self.gesture
        self.gesture = ""
        if name:
            self._request(self._before)

    def clear_path(self) -> None:
        """Remove the drawn path: the controller then places a path at the first contact, or holds its location."""
        if self.settings.path:
            self.do("clear the path", controller=self.settings.controller, path=())
        else:
            self.notified.emit("No path to clear")

    def undo(self) -> None:
        """Undo the last step, or cancel the current gesture."""
        if self.gesture:
            self.cancel()
            return
        name = self.steps.undo_step.name
        if name and self.enabled:
            self._request(self.steps.undo(self.settings))
            self.notified.emit(f"Undone: {name}")

    def redo(self) -> None:
        """Redo the last undone step."""
        name = self.steps.redo_step.name
        if name and self.enabled and not self.gesture:
            self._request(self.steps.redo(self.settings))
            self.notified.emit(f"Redone: {name}")

    def _request(self, settings: ControlSettings) -> None:
        if self.enabled and settings != self.settings:
            self.settings = settings
            self.settings_requested.emit(settings)
        self.changed.emit()
