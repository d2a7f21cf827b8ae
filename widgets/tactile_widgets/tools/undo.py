"""Undo and redo of map, skin, controller settings and posture, in the order in which the edits were made."""

from __future__ import annotations

from typing import Protocol

from tactile_maps.editing.history import NO_STEP, Step
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.skin_steps import SkinSteps
from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.tools.control.path_tool import PathTool


class Undoable(Protocol):
    """Object whose last step can be undone."""

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to redo."""

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts; ``NO_STEP`` without one."""

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` repeats; ``NO_STEP`` if there is none."""

    def undo(self) -> None:
        """Undo the last step."""

    def redo(self) -> None:
        """Redo the last undone step."""


class CancellableUndo(Undoable, Protocol):
    """An undo stack whose ``undo`` first cancels something that is in progress."""

    @property
    def unfinished(self) -> bool:
        """Whether something is in progress that ``undo`` cancels first, such as a drag."""


class UndoInOrder:
    """Undo and redo of several stacks, in the order in which their edits were made. Mutable.

    Something in progress is undone first. An edit makes the edits that were undone before impossible to redo here,
    whatever their stack; the map keeps its own for the panel *History*.

    Args:
        stacks: The stacks.
    """

    def __init__(self, *stacks: CancellableUndo) -> None:
        self._stacks = stacks
        self._newest = 0
        self._outdated: set[int] = set()  # numbers of steps that cannot be redone

    def note_edit(self) -> None:
        """Note an edit, if one was made since the last call; one that is in progress may still be refused."""
        newest = max((stack.undo_step.number for stack in self._stacks if not stack.unfinished), default=0)
        if newest > self._newest:
            self._newest = newest
            self._outdated.update(stack.redo_step.number for stack in self._stacks)

    @property
    def _to_undo(self) -> CancellableUndo | None:
        """The stack of the last edit."""
        able = (stack for stack in self._stacks if stack.can_undo)
        return max(able, key=lambda stack: (stack.unfinished, stack.undo_step.number), default=None)

    @property
    def _to_redo(self) -> CancellableUndo | None:
        """The stack of the first undone edit; None while something is in progress."""
        able = (stack for stack in self._stacks if stack.can_redo and stack.redo_step.number not in self._outdated)
        first = min(able, key=lambda stack: stack.redo_step.number, default=None)
        return None if any(stack.unfinished for stack in self._stacks) else first

    @property
    def can_undo(self) -> bool:
        """Whether there is an edit to undo, or something in progress."""
        return self._to_undo is not None

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone edit to redo."""
        return self._to_redo is not None

    @property
    def undo_step(self) -> Step:
        """The edit that ``undo`` reverts."""
        return NO_STEP if self._to_undo is None else self._to_undo.undo_step

    @property
    def redo_step(self) -> Step:
        """The edit that ``redo`` repeats."""
        return NO_STEP if self._to_redo is None else self._to_redo.redo_step

    def undo(self) -> None:
        """Cancel something in progress, or undo the last edit."""
        if (stack := self._to_undo) is not None:
            stack.undo()

    def redo(self) -> None:
        """Redo the first undone edit."""
        if (stack := self._to_redo) is not None:
            stack.redo()


class MapUndo:
    """Undo of map edits and of the changes of the skin between them."""

    def __init__(self, editor: MapEditor, skins: SkinSteps) -> None:
        self._editor = editor
        self._skins = skins

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo or an edit being computed."""
        history = self._editor.history
        editor = self._editor
        return history is not None and editor.enabled and (history.can_undo or editor.busy or self._skins.can_undo)

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to redo."""
        history = self._editor.history
        return history is not None and self._editor.enabled and (history.can_redo or self._skins.can_redo)

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts."""
        history = self._editor.history
        if history is None or not history.position or self._skins.pending:
            return self._skins.undo_step
        return max(history.undo_step, self._skins.undo_step, key=lambda step: step.number)

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` repeats."""
        history = self._editor.history
        return history.redo_step if history is not None and history.can_redo else self._skins.redo_step

    @property
    def unfinished(self) -> bool:
        """Whether there is a gesture, or an edit or a skin is being made."""
        return self._editor.unfinished or self._skins.pending

    def undo(self) -> None:
        """Undo the last map edit, or the last change of the skin; one that is being made is cancelled first."""
        editor = self._editor
        history = self._editor.history
        if self._skins.pending and not editor.gesture:
            self._skins.undo()
        elif history is None or history.can_undo or editor.busy or editor.proposal is not None:
            editor.undo()
        else:
            self._skins.undo()

    def redo(self) -> None:
        """Redo the last undone map edit, or change of the skin."""
        history = self._editor.history
        if history is None or history.can_redo:
            self._editor.redo()
        else:
            self._skins.redo()


class ControlUndo:
    """Undo of path, target and force, and of the corners of a path while it is being drawn."""

    def __init__(self, control: ControlSettingsEditor, path: PathTool) -> None:
        self._control = control
        self._path = path

    @property
    def can_undo(self) -> bool:
        """Whether there is a corner, a gesture or a step to undo."""
        return self._control.enabled and (self.unfinished or bool(self.undo_step.number))

    @property
    def can_redo(self) -> bool:
        """Whether there is an undone step to redo."""
        return self._control.enabled and bool(self.redo_step.number)

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts."""
        return self._control.steps.undo_step

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` repeats."""
        return self._control.steps.redo_step

    @property
    def unfinished(self) -> bool:
        """Whether a path is being drawn, or there is a gesture."""
        return self._path.drawing or bool(self._control.gesture)

    def undo(self) -> None:
        """Remove the last corner of the path being drawn, or undo the last step."""
        if self._path.drawing:
            self._path.remove_last()
        else:
            self._control.undo()

    def redo(self) -> None:
        """Redo the last undone step."""
        self._control.redo()
