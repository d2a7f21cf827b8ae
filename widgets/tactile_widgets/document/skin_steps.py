"""Undo and redo of changes of the skin: taxel grids, and covers on other links or with other taxels."""

from __future__ import annotations

from dataclasses import dataclass, replace

from PySide6.QtCore import QObject, Signal

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.history import NO_STEP, Step
from tactile_maps.scene.scene import Scene
from tactile_widgets.document.map_editor import MapEditor

_FIRST = "Open"


def have_same_skin(first: Scene, second: Scene) -> bool:
    """Whether two scenes specify the same taxels on the same robot."""
    parts = ("robot", "taxel_files", "cover", "grids", "more_covers")
    return all(getattr(first, name) == getattr(second, name) for name in parts)


@dataclass(frozen=True, eq=False)
class _SkinStep(Step):
    """The step that led to a scene, and the document of that scene at the time of the next step."""

    scene: Scene
    document: MapDocument | None = None


class SkinSteps(QObject):
    """Scenes before and after each change of the skin, to undo and redo them. Mutable.

    Args:
        editor: Editor of the shown scene's document; None allows a redo with any document.
        parent: Qt parent.
    """

    changed = Signal()
    """The steps that can be undone or redone changed."""
    scene_requested = Signal(Scene)
    """Open this scene."""
    cancel_requested = Signal(str)
    """Stop opening a scene, because of an undo or another step; the name of the step that it is for, or empty."""

    def __init__(self, editor: MapEditor | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._steps: list[_SkinStep] = []  # the first led to the scene before all changes
        self._at = 0  # the scene that is shown
        self._requested = 0  # the scene that is shown once it is open
        self._from_start = False
        self._is_new = False  # the requested step was not made before

    @property
    def pending(self) -> bool:
        """Whether the requested scene is not open yet."""
        return self._requested != self._at

    @property
    def requested_name(self) -> str:
        """Name of the step that led to the requested scene."""
        return self._steps[self._requested].name if self._steps else _FIRST

    @property
    def from_start(self) -> bool:
        """Whether the map of the requested scene is shown without the edits that were made of it then."""
        return self._from_start

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo, or one whose scene is being opened."""
        return self.pending or self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was undone, without map edits since; undone edits of the map before it are redone first."""
        return not self.pending and self._follows

    @property
    def _follows(self) -> bool:
        """Whether the step after the scene that is shown follows from the map as it is."""
        if self._at >= len(self._steps) - 1:
            return False
        history = None if self._editor is None else self._editor.history
        document = self._steps[self._at].document
        return history is None or (document is not None and history.reaches(document))

    @property
    def undo_step(self) -> Step:
        """The step that ``undo`` reverts."""
        return self._steps[max(self._at, self._requested)] if self.can_undo else NO_STEP

    @property
    def redo_step(self) -> Step:
        """The step that ``redo`` repeats."""
        return self._steps[self._at + 1] if self.can_redo else NO_STEP

    def push(self, name: str, before: Scene, after: Scene) -> None:
        """Add the step ``name`` from scene ``before`` to scene ``after`` and request to open ``after``."""
        self.cancel()
        kept = self._steps[: self._at + 1] or [_SkinStep(_FIRST, before, number=0)]
        self._steps = [*kept, _SkinStep(name, after)]
        self._keep_document()
        self._request(len(kept), from_start=True)
        self._is_new = self.pending

    def _keep_document(self) -> None:
        if self._editor is not None:
            self._steps[self._at] = replace(self._steps[self._at], document=self._editor.document)

    @property
    def names_before(self) -> tuple[str, ...]:
        """Names of the skins before the current one, oldest first: of the step that led to each."""
        return tuple(step.name for step in self._steps[: self._at])

    @property
    def names_after(self) -> tuple[str, ...]:
        """Names of the steps that can be redone, or that are being made."""
        return tuple(step.name for step in self._steps[self._at + 1 :]) if self._follows else ()

    def undo(self) -> None:
        """Cancel a step whose scene is being opened; else undo the last step, which returns to the last edit before."""
        if self.pending:
            self.cancel()
        elif self.can_undo:
            self.cancel()
            self._request(self._at - 1, from_start=False)

    def redo(self) -> None:
        """Redo the last undone step."""
        if self.can_redo:
            self.go(1)

    def go(self, steps: int) -> None:
        """Undo as many steps, or redo them if ``steps`` is positive, without the edits of the map after them."""
        if self._at + steps != self._requested:
            self.cancel()
            self._request(self._at + steps, from_start=True)

    def note_edits(self) -> None:
        """Note that the map was edited while the requested scene was being opened, before that is shown."""
        if self._requested > self._at:
            self._keep_document()

    def show_scene(self, scene: Scene) -> None:
        """Find the opened scene among the steps, the requested one first; another scene discards them."""
        found = [number for number, step in enumerate(self._steps) if have_same_skin(step.scene, scene)]
        at = self._requested if self._requested in found else next(iter(found), None)
        if at is None:
            self._steps = []
        elif self._is_new and at == self._requested:
            step = self._steps[at]
            self._steps[at] = _SkinStep(step.name, step.scene, step.document)  # follows edits made while it was opened
        self._is_new = False
        self._at = at or 0
        self._requested = self._at  # which may have failed to open
        self.changed.emit()

    def cancel(self) -> None:
        """Stop opening the requested scene, or any other."""
        name = self.undo_step.name if self.pending else ""
        self._requested = self._at
        self._is_new = False
        self.cancel_requested.emit(name)
        self.changed.emit()

    def _request(self, number: int, *, from_start: bool) -> None:
        self._requested = number
        self._from_start = from_start
        self.changed.emit()
        self.scene_requested.emit(self._steps[number].scene)
