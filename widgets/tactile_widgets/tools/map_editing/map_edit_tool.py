"""Base class of map editing tools: edit requests, one at a time, and marks on the body."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import ReflattenRequest
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.map_editing.mesh_picking import present_seams, seam_runs
from tactile_widgets.views.interaction.view_tool import ViewTool
from tactile_widgets.views.overlays.body_overlays import EdgeMark, MarkRole, ToolMarks

_BUSY = "Another edit is being computed: wait for it, or cancel it"


class MapEditTool(ViewTool):
    """Tool whose edits are computed in the background.

    Args:
        editor: Editor of the map document.
        parent: Qt parent.
    """

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._mine = False
        self._marks: ToolMarks | None = None
        self._marked: MapDocument | None = None
        self._skin: Skin | None = None if editor.document is None else editor.document.skin
        editor.shown.connect(self._on_shown)
        editor.rested.connect(self._on_rested)
        editor.proposal_changed.connect(self._redraw)

    @property
    def _document(self) -> MapDocument | None:
        """Document to edit; None while editing is disabled."""
        return self._editor.document if self._editor.enabled else None

    def _request(
        self, request: Callable[[MapDocument], ReflattenRequest], *, refine: bool = False, propose: bool = False
    ) -> bool:
        """Request an edit; return whether it was accepted. The request of another tool is not discarded."""
        if not self._can_request():
            return False
        accepted = []

        def recorded(document: MapDocument) -> ReflattenRequest:
            accepted.append(request(document))
            return accepted[0]

        self._editor.ask(recorded, refine=refine, propose=propose)
        self._mine = self._editor.busy
        return bool(accepted)

    @property
    def _free(self) -> bool:
        """Whether no other tool waits for an edit."""
        return self._mine or not self._editor.busy

    def _can_request(self) -> bool:
        """Whether no other tool waits for an edit; shows a message if one does."""
        if not self._free:
            self._editor.notified.emit(_BUSY)
        return self._free

    def body_marks(self) -> ToolMarks:
        """Return seams and marks of this tool; the same object until they change."""
        if self._marks is None:
            self._marked = self._editor.document
            self._marks = ToolMarks() if self._marked is None else self._mark_body(self._marked)
        return self._marks

    def _mark_body(self, document: MapDocument) -> ToolMarks:
        return ToolMarks(document.skin, lines=seam_lines(document))

    def _redraw(self) -> None:
        """Redraw map and body."""
        self._marks = None
        self.drawn.emit()

    def _forget(self) -> None:
        """Discard positions on the previous skin, because another skin is edited."""

    def _on_shown(self, document: MapDocument) -> None:
        if document.skin is not self._skin:
            self._skin = document.skin
            self._forget()
        if self._marked is None or not _same_marks(self._marked, document):
            self._marks = None
        self.drawn.emit()

    def _on_rested(self) -> None:
        self._mine = False
        self._redraw()


def seam_lines(document: MapDocument) -> tuple[EdgeMark, ...]:
    """Return the seams of all patches, on the body."""
    return tuple(
        EdgeMark(number, run, MarkRole.SEAM)
        for number in range(len(document.patches))
        for run in seam_runs(present_seams(document, number))
    )


def _same_marks(one: MapDocument, other: MapDocument) -> bool:
    """Whether seams, areas of interest and pins are at the same locations of the same body."""
    if one.skin is not other.skin:
        return False
    return all(
        a.seams is b.seams and c.seams is d.seams and [pin.at for pin in a.pins] == [pin.at for pin in b.pins]
        for a, b, c, d in zip(one.patches, other.patches, one.charts, other.charts, strict=True)
    )
