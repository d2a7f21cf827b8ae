"""Undo and redo of changes of the skin: taxel grids, and covers on other links or with other taxels."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from tactile_maps.editing.document import MapDocument
from tactile_maps.scene.scene import Scene
from tactile_widgets.document.map_editor import MapEditor


def have_same_skin(first: Scene, second: Scene) -> bool:
    """Whether two scenes specify the same taxels on the same robot."""
    parts = ("robot", "taxel_files", "cover", "grids", "more_covers")
    return all(getattr(first, name) == getattr(second, name) for name in parts)


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

    def __init__(self, editor: MapEditor | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._scenes: list[Scene] = []
        self._names: list[str] = []  # of the steps between two scenes
        self._documents: list[MapDocument | None] = []  # at the time of the next step
        self._at = 0

    @property
    def can_undo(self) -> bool:
        """Whether there is a step to undo."""
        return self._at > 0

    @property
    def can_redo(self) -> bool:
        """Whether a step was undone, without map edits since."""
        return self._at < len(self._scenes) - 1 and self._documents[self._at] is self._document

    @property
    def _document(self) -> MapDocument | None:
        return None if self._editor is None else self._editor.document

    @property
    def undo_name(self) -> str:
        """Name of the step that ``undo`` reverts; empty if there is none."""
        return self._names[self._at - 1] if self.can_undo else ""

    @property
    def redo_name(self) -> str:
        """Name of the step that ``redo`` repeats; empty if there is none."""
        return self._names[self._at] if self.can_redo else ""

    def push(self, name: str, before: Scene, after: Scene) -> None:
        """Add the step ``name`` from scene ``before`` to scene ``after`` and request to open ``after``."""
        kept = self._scenes[: self._at + 1] if self._scenes else [before]
        self._names = [*self._names[: self._at], name]
        self._documents = [*self._documents[: self._at], self._document]
        self._scenes = [*kept, after]
        self._at = len(kept)
        self._show()

    @property
    def names_before(self) -> tuple[str, ...]:
        """Names of the skins before the current one, oldest first: of the step that led to each."""
        return ("Open", *self._names)[: self._at]

    @property
    def names_after(self) -> tuple[str, ...]:
        """Names of the steps that can be redone."""
        return tuple(self._names[self._at :]) if self.can_redo else ()

    def undo(self) -> None:
        """Undo the last step."""
        if self.can_undo:
            self.go(-1)

    def redo(self) -> None:
        """Redo the last undone step."""
        if self.can_redo:
            self.go(1)

    def go(self, steps: int) -> None:
        """Undo as many steps, or redo them if ``steps`` is positive."""
        self._at += steps
        self._show()

    def show_scene(self, scene: Scene) -> None:
        """Find the opened scene among the steps; another scene discards them."""
        at = next((number for number, one in enumerate(self._scenes) if have_same_skin(one, scene)), None)
        if at is None:
            self._scenes = []
            self._names = []
            self._documents = []
            self._at = 0
        else:
            self._at = at  # the requested scene may have failed to open
        self.changed.emit()

    def _show(self) -> None:
        self.changed.emit()
        self.scene_requested.emit(self._scenes[self._at])
