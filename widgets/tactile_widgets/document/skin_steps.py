"""Undo and redo of changes of the skin: taxel grids, and covers on other links or with other taxels.

Each step has a document of its own, also one that returns to an earlier skin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from PySide6.QtCore import QObject, Signal

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import DocumentFile
from tactile_maps.editing.history import NO_STEP, History, Step
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.scene.effects import Override
from tactile_maps.scene.scene import Scene
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.document.step_list import Change

_FIRST = "Open"


def have_same_skin(first: Scene, second: Scene) -> bool:
    """Whether two scenes specify the same taxels on the same robot."""
    parts = ("robot", "taxel_files", "cover", "grids", "more_covers")
    return all(getattr(first, name) == getattr(second, name) for name in parts)


ControlStep = Change[dict[str, Any]]


@dataclass(frozen=True, eq=False)
class StepsOnSkin:
    """Steps of the controller settings when the skin was changed, with their values on the map that it had.

    Attributes:
        map: The map; of a skin that was not shown before, the map that it will have.
        steps: Steps by number, also undone ones.
        done: Numbers of those that were not undone, oldest first.
    """

    map: TactileMap
    steps: Mapping[int, ControlStep] = field(default_factory=dict)
    done: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class KeptDocument:
    """A scene before or after a change of the skin, and its document.

    Attributes:
        prepared: The scene.
        settings: Its settings.
        control: Steps of these settings.
        overrides: Effects that were chosen in it.
        history: The document with its steps.
        file: The file of the document.
        first: The document without edits.
    """

    prepared: PreparedScene
    settings: RuntimeSettings
    control: StepsOnSkin
    overrides: Mapping[str, Override]
    history: History
    file: DocumentFile
    first: MapDocument


@dataclass(frozen=True, eq=False)
class _SkinStep(Step):
    """The step that led to a scene.

    Attributes:
        scene: The scene.
        document: The map of that scene from which the next step was made; None without a next step.
        kept: The scene and its document when it was shown last; None until another scene is requested.
    """

    scene: Scene
    document: MapDocument | None = None
    kept: KeptDocument | None = None


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
        self._replaced: list[_SkinStep] | None = None  # the steps without the requested one, if that is new

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
        """Whether the step after the scene that is shown follows from the current map."""
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
        """Request to open ``after``, as the step ``name`` from scene ``before``.

        The step replaces those that were undone, unless its scene is not opened: then all steps are as before.
        """
        self.cancel()
        done = self._steps[: self._at + 1] or [_SkinStep(_FIRST, before, number=0)]
        self._replaced = self._steps
        self._steps = [*done, _SkinStep(name, after)]
        self._request(len(done), from_start=True)

    @property
    def names_before(self) -> tuple[str, ...]:
        """Names of the skins before the current one, oldest first: of the step that led to each."""
        return tuple(step.name for step in self._steps[: self._at])

    @property
    def names_after(self) -> tuple[str, ...]:
        """Names of the steps that can be redone, or that are being made."""
        return tuple(step.name for step in self._steps[self._at + 1 :]) if self._follows else ()

    def undo(self) -> None:
        """Cancel a step whose scene is being opened, which can then be redone; else undo the last step.

        Undo of a step returns to the last edit before it.
        """
        if self.pending:
            self._replaced = None
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

    # The documents.

    @property
    def before(self) -> KeptDocument | None:
        """The document that is shown, as it was kept last; None before the first step."""
        return self._steps[self._at].kept if self._steps else None

    @property
    def after(self) -> KeptDocument | None:
        """The document of the requested scene; None if that was not shown before."""
        return self._steps[self._requested].kept if self._steps else None

    def keep(self, document: KeptDocument) -> None:
        """Keep the document that is shown; a scene that was not shown before follows from its present map."""
        step = replace(self._steps[self._at], kept=document)
        self._steps[self._at] = replace(step, document=document.history.present) if self.after is None else step
        self.changed.emit()

    def expects(self, scene: Scene) -> bool:
        """Whether this is the requested scene, until ``show_requested``."""
        return self.pending and have_same_skin(self._steps[self._requested].scene, scene)

    def show_requested(self) -> None:
        """Note that the requested scene is shown; a new step then follows the edits made while it was opened."""
        at = self._at = self._requested
        if self._replaced is not None:
            self._steps[at] = _SkinStep(self._steps[at].name, self._steps[at].scene)
        self._replaced = None
        self.changed.emit()

    def stop(self) -> None:
        """Note that the requested scene is not opened; a new step was not made then."""
        if self._replaced is not None:
            self._steps = self._replaced
        self._replaced = None
        self._requested = self._at
        self.changed.emit()

    def reset(self) -> None:
        """Discard all steps, because another scene is shown."""
        self._steps = []
        self._replaced = None
        self._at = 0
        self.stop()

    def cancel(self) -> None:
        """Stop opening the requested scene, or any other."""
        name = self.undo_step.name if self.pending else ""
        self.stop()
        self.cancel_requested.emit(name)

    def _request(self, number: int, *, from_start: bool) -> None:
        self._requested = number
        self._from_start = from_start
        self.changed.emit()
        self.scene_requested.emit(self._steps[number].scene)
