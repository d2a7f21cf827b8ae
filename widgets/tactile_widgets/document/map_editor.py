"""Editor of the map document, and the only code that changes it; views, panels and tools call it.

``MapEditorSignals`` lists the changes that it reports. Edits are applied at once, as gestures that are one step, or
computed in the background.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

from PySide6.QtCore import QObject, Signal

from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.history import History
from tactile_maps.editing.reflatten import ReflattenRequest, ReflattenResult, StaleEdit, apply_result
from tactile_widgets.jobs.scene_jobs import SceneJobs


@dataclass(frozen=True, eq=False)
class Proposal:
    """A computed edit that waits to be accepted.

    Attributes:
        result: The computed charts.
        gain: Share of the patch's distortion that the edit removes; None if unknown.
    """

    result: ReflattenResult
    gain: float | None


class MapEditorSignals(QObject):
    """Signals that report changes of the document after they happened."""

    shown = Signal(MapDocument)
    """Current document, also during a gesture."""
    settled = Signal(MapDocument, str)
    """Document and name of the step that was done, undone or redone; never during a gesture."""
    history_changed = Signal()
    """The steps, or the position among them, changed."""
    gesture_changed = Signal()
    """A gesture began or ended."""
    selection_changed = Signal()
    """Other patches are selected."""
    working = Signal(str, float)
    """Progress of an edit that is being computed: its name, and the share done, 0 to 1."""
    rested = Signal()
    """The computed edit has finished, failed or been cancelled."""
    failed = Signal(str)
    """Reason why an edit was rejected. The document is unchanged."""
    notified = Signal(str)
    """Message for the status line."""
    proposal_changed = Signal()
    """A proposal arrived, or was accepted or declined."""
    enabled_changed = Signal(bool)
    """True if edits are accepted."""


Edit = Callable[[MapDocument], MapDocument]
Request = Callable[[MapDocument], ReflattenRequest]
_ISOMETRY = 4.0
"""Mean symmetric Dirichlet energy of a map without distortion."""


@dataclass(frozen=True)
class _PendingEdit:
    """An edit that is being computed, and the use of its result."""

    name: str
    refine: bool
    propose: bool
    position: int


class MapEditor(MapEditorSignals):
    """A document with its history, its selected patches, and the edit being computed.

    Args:
        jobs: Flattens patches; may be shared.
        parent: Qt parent.

    Attributes:
        history: Undo and redo; None without a document.
        proposal: A seam that waits to be accepted, or None.
        enabled: True if edits are accepted.
    """

    def __init__(self, jobs: SceneJobs, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._jobs = jobs
        self.history: History | None = None
        self.proposal: Proposal | None = None
        self.enabled = False
        self._selected: tuple[int, ...] = ()
        self._pending: _PendingEdit | None = None
        self._before: MapDocument | None = None
        self._late: tuple[_PendingEdit, ReflattenResult] | None = None
        self._series: tuple[object, int] | None = None  # the series of the newest step, and its position

    @property
    def document(self) -> MapDocument | None:
        """Current document, also during a gesture; None before the first."""
        return None if self.history is None else self.history.present

    @property
    def busy(self) -> bool:
        """True while an edit is being computed."""
        return self._pending is not None

    @property
    def unfinished(self) -> bool:
        """True during a gesture, and while an edit that is no step yet is computed or proposed."""
        computing = self._pending is not None and not self._pending.refine
        return self.gesture or self.proposal is not None or computing

    @property
    def gesture(self) -> bool:
        """True during a gesture."""
        return self._before is not None

    @property
    def selected(self) -> tuple[int, ...]:
        """Numbers of the selected patches, ascending."""
        return self._selected

    def open(self, document: MapDocument, *, name: str = "Open", edits: tuple[str, MapDocument] | None = None) -> None:
        """Edit another document; steps of the previous one can no longer be undone.

        Args:
            document: The first step.
            name: Name of the first step.
            edits: Name and document of a second step, which is shown instead.
        """
        self._forget()
        self.history = History(document, name=name)
        if edits is not None:
            self.history.do(*edits)
        self._select(())
        self._show(self.history.names[-1])

    def resume(self, history: History) -> None:
        """Edit a document that was edited before, with its steps."""
        self._forget()
        self.history = history
        self._select(())
        self._show(history.names[history.position])

    def set_enabled(self, *, enabled: bool) -> None:
        """Accept edits or not; the current gesture is cancelled.

        A computation continues; a result that arrives while edits are not accepted is applied when they are again.
        """
        if enabled != self.enabled:
            self.cancel()
            self.enabled = enabled
            self.enabled_changed.emit(enabled)
            self._take_late()

    def select(self, numbers: Iterable[int]) -> None:
        """Select these patches, and no others."""
        count = 0 if self.document is None else len(self.document.patches)
        self._select(tuple(sorted({number for number in numbers if 0 <= number < count})))

    def do(self, name: str, edit: Edit, *, series: object = None) -> bool:
        """Apply an edit as one step, after ending the current gesture; return whether it was accepted.

        Args:
            name: Name of the step.
            edit: The edit.
            series: Edits of the same series that follow one another, such as presses of arrow keys, are one step; None
                for a step of its own.
        """
        self.end()
        history = self.history
        before = self._series
        self._series = None
        if history is None or not self.enabled:
            return False
        if series is not None and before == (series, history.position) and not history.can_redo:
            self.decline()
            try:
                history.refine(edit(history.present))
            except MapError as error:
                self.failed.emit(str(error))
                return False
            self._show(name)
        elif not (self.begin(name) and self._finish(edit)):
            return False
        self._series = None if series is None else (series, history.position)
        return True

    def _finish(self, edit: Edit) -> bool:
        taken = self.change(edit)
        if taken:
            self.end()
        else:
            self.cancel()
        return taken

    def begin(self, name: str) -> bool:
        """Start a gesture; return False if edits are not accepted or another gesture is in progress."""
        if self.history is None or not self.enabled or self.gesture:
            return False
        self.decline()
        self._series = None
        self.history.begin(name)
        self._before = self.history.present
        self.gesture_changed.emit()
        return True

    def change(self, edit: Edit) -> bool:
        """Apply ``edit`` to the document from the start of the gesture; return whether it was accepted."""
        if self.history is None or self._before is None:
            return False
        try:
            document = edit(self._before)
        except MapError as error:
            self.failed.emit(str(error))
            return False
        if document is not self.history.present:
            self.history.change(document)
            self.shown.emit(document)
        return True

    def end(self) -> None:
        """Complete the gesture as one step; without a change there is no step."""
        if self.history is None or self._before is None:
            return
        changed = self.history.present is not self._before
        name = self.history.gesture
        self._before = None
        self.history.end()
        self.gesture_changed.emit()
        if changed:
            self._show(name)
        self._take_late()

    def cancel(self) -> None:
        """Discard the gesture."""
        if self.history is None or self._before is None:
            return
        self._before = None
        self.history.cancel()
        self.gesture_changed.emit()
        self.shown.emit(self.history.present)
        self._take_late()

    # Edits that are computed.

    def ask(self, request: Request, *, refine: bool = False, propose: bool = False) -> None:
        """Compute an edit in the background, instead of the current one.

        Args:
            request: Returns the patches to flatten; with none, nothing happens.
            refine: Whether the result replaces the current step instead of adding one.
            propose: Whether the result waits as ``proposal``.
        """
        self.end()
        if self.history is None or not self.enabled:
            return
        self.decline()
        try:
            edit = request(self.history.present)
        except MapError as error:
            self.failed.emit(str(error))
            return
        if not edit.jobs:
            return
        pending = _PendingEdit(edit.name, refine, propose, self.history.position)
        self._pending = pending
        self.working.emit(edit.name, 0.0)
        self._jobs.reflatten(
            edit, partial(self._on_reflattened, pending), partial(self._on_edit_failed, pending), self.working.emit
        )

    def cancel_work(self) -> None:
        """Cancel the edit that is being computed."""
        if self._pending is not None:
            name = self._rest()
            self._jobs.cancel_edit()
            self.notified.emit(f"{name}: cancelled")

    def accept(self) -> None:
        """Apply the proposal as a step."""
        if self.proposal is not None:
            result = self._take_proposal()
            if result is not None:
                self._put_in(result, result.request.name.replace("Propose", "Accept"), refine=False)

    def decline(self) -> None:
        """Discard the proposal."""
        self._take_proposal()

    def undo(self) -> None:
        """Undo a step; first a gesture, a proposal or an edit that is being computed."""
        if self.gesture:
            self.cancel()
        elif self.proposal is not None:
            self.decline()
        elif self._pending is not None and not self._pending.refine:
            self.cancel_work()
        elif self.history is not None and self.history.position:
            self.go(self.history.position - 1)

    def redo(self) -> None:
        if self.history is not None and self.history.can_redo:
            self.go(self.history.position + 1)

    def go(self, position: int) -> None:
        """Go to a step of the history; a computation for the current step is cancelled."""
        if self.history is None or not self.enabled:
            return
        self._forget()
        back = position < self.history.position
        name = self.history.names[self.history.position if back else position]
        self.history.go(position)
        self._show(f"Undo: {name}" if back else f"Redo: {name}")

    def _show(self, name: str) -> None:
        assert self.history is not None
        self.settled.emit(self.history.present, name)  # first, so that measurements run while the views draw
        self.shown.emit(self.history.present)
        self.history_changed.emit()

    def _select(self, numbers: tuple[int, ...]) -> None:
        if numbers != self._selected:
            self._selected = numbers
            self.selection_changed.emit()

    def _forget(self) -> None:
        """Cancel a gesture, a proposal and a computation."""
        self._series = None
        self._late = None
        self.cancel()
        self.decline()
        if self._pending is not None:
            self._rest()
            self._jobs.cancel_edit()

    def _rest(self) -> str:
        name = "" if self._pending is None else self._pending.name
        self._pending = None
        self.rested.emit()
        return name

    def _take_proposal(self) -> ReflattenResult | None:
        proposal = self.proposal
        self.proposal = None
        if proposal is not None:
            self.proposal_changed.emit()
        return None if proposal is None else proposal.result

    def _on_reflattened(self, pending: _PendingEdit, result: ReflattenResult) -> None:
        if pending is not self._pending:
            return  # for a document that is no longer edited
        self._rest()
        if not self.enabled or (self.gesture and not pending.propose):
            self._late = pending, result  # edits are not accepted, or a gesture has priority
        else:
            self._take(pending, result)

    def _take_late(self) -> None:
        """Apply a result that arrived while edits were not accepted."""
        if self._late is not None and self.enabled:
            late = self._late
            self._late = None
            self._take(*late)

    def _take(self, pending: _PendingEdit, result: ReflattenResult) -> None:
        if pending.propose:
            self.proposal = Proposal(result, _gain(result))
            self.proposal_changed.emit()
        elif self.history is not None:
            self._put_in(result, pending.name, refine=pending.refine and pending.position == self.history.position)

    def _put_in(self, result: ReflattenResult, name: str, *, refine: bool) -> None:
        assert self.history is not None
        try:
            document = apply_result(self.history.present, result)
        except StaleEdit as error:
            self.notified.emit(str(error))
            return
        if refine:
            self.history.refine(document)
        else:
            self.history.do(name, document)
        self._show(name)

    def _on_edit_failed(self, pending: _PendingEdit, text: str) -> None:
        if pending is self._pending:
            self._rest()
            if text:
                self.failed.emit(text)


def _gain(result: ReflattenResult) -> float | None:
    before = result.request.jobs[0].before.energies
    gain = result.gains[0]
    return gain / (before[-1] - _ISOMETRY) if gain is not None and before[-1] > _ISOMETRY else None
