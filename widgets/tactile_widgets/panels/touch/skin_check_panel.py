"""Guided check of the connected skin: the part to press is lit on body and map, and faulty channels are listed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TypeVar

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import TactileMapsError, counted, names_text
from tactile_maps.editing.layout_import import same_skin
from tactile_maps.live.checking.report import check_facts, swap_texts, write_check_report
from tactile_maps.live.checking.skin_check import CheckStage, Outcome, SkinCheck
from tactile_maps.live.checking.verdicts import FAULT_TEXTS, verdicts_of
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.make import SteadyLabel, add_fact, make, progress_bar, push_button, row_layout, value_label
from tactile_widgets.common.note_list import Note, NoteList
from tactile_widgets.common.sentence import as_sentence
from tactile_widgets.panels.touch.connected_panel import ConnectedPanel
from tactile_widgets.session.live_input import LiveInput

_REFRESH_MS = 100
_IDLE = "Press the modules of the skin one after another; faulty channels are found by what they send."
_DONE = "Done. The faulty channels are selected on body and map."
_UNPRESSED = "Done, but nothing was pressed: only missing values and noise were checked."
_NO_NOTES = "Faulty channels are listed here."
_NAMED = 12
"""Maximum number of channels that a note names; the report lists all."""

T = TypeVar("T")


@dataclass(frozen=True)
class _Ended:
    """The check of a connection that was closed.

    Attributes:
        check: The check.
        facts: Date, source and files for its report.
        points: (taxels, 2) places of the taxels on the map [m].
    """

    check: SkinCheck
    facts: Mapping[str, object]
    points: FloatArray


class SkinCheckPanel(ConnectedPanel):
    """Steps of the check with its keys, and its result. The taxels to press are selected, felt ones are green.

    The result is kept for the next connection to the same skin, until another check begins.
    """

    report_requested = Signal()
    """The user saves the report; the receiver asks for a file and calls ``save_report``."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Skin check", "skin-check-panel", _REFRESH_MS, parent)
        self._started: datetime | None = None
        self._ended = False
        self._earlier: _Ended | None = None
        self._error = ""
        self._prompt = make(SteadyLabel, _IDLE, self, objectName="check-prompt", wordWrap=True)
        self._prompt.setAlignment(Qt.AlignmentFlag.AlignTop)
        self._prompt.setMinimumHeight(3 * self._prompt.fontMetrics().lineSpacing())
        self._progress = progress_bar(self, "Parts checked")
        self._start = push_button(
            self, "check-start", "Check the skin…", "Begin; the skin must be untouched", self._on_start_clicked
        )
        tip = "Write a web page with all parts, channels and readings"
        self._save = push_button(self, "check-save", "Save report…", tip, self.report_requested)
        tip = "Press the previous part again"
        self._back = push_button(self, "check-back", "Back", tip, self._on_back_clicked)
        tip = "Leave this part without a result"
        self._skip = push_button(self, "check-skip", "Skip", tip, self._on_skip_clicked)
        tip = "Go to the next part; this one counts as pressed"
        self._next = push_button(self, "check-next", "Next", tip, self._on_next_clicked)
        tip = "End the check; the remaining parts are not checked"
        self._finish = push_button(self, "check-finish", "Finish", tip, self._on_finish_clicked)
        self.column.addWidget(self._prompt)
        self.column.addWidget(self._progress)
        self.column.addLayout(row_layout(self._start, self._save))
        self.column.addLayout(row_layout(self._back, self._skip, self._next, self._finish))
        grid = self.grid()
        grid.setColumnStretch(0, 1)
        self._felt = value_label("–", self, right=True, objectName="check-felt")
        self._parts = value_label("–", self, right=True, objectName="check-parts")
        add_fact(grid, 0, "Parts felt", "Parts of the skin that responded when they were pressed", self._parts)
        add_fact(grid, 1, "Taxels felt", "Taxels that were felt during the check", self._felt)
        self._notes = NoteList("check-notes", "Faulty channels", _NO_NOTES, self)
        self.column.addWidget(self._notes)

    def show_input(self, live: LiveInput | None) -> None:
        self._keep_check()
        self._started = None
        self._ended = False
        self._error = ""
        self._notes.show_notes([])
        super().show_input(live)

    def show_prepared(self, prepared: PreparedScene) -> None:
        if self._earlier is not None and not same_skin(self._earlier.check.skin, prepared.skin):
            self._earlier = None

    def refresh(self) -> None:
        if self._input is None or self.folded:
            return
        shown = self._with_check(_Shown)
        going = shown is not None and shown.stage is not CheckStage.DONE
        pressing = shown is not None and shown.stage is CheckStage.PRESS
        self._start.setText("Check again…" if shown is not None else "Check the skin…")
        for button, enabled in (
            (self._start, not going),
            (self._save, shown is not None and shown.stage is not CheckStage.REST),
            (self._back, shown is not None and shown.stage is not CheckStage.REST and self._earlier is None),
            (self._skip, pressing),
            (self._next, pressing),
            (self._finish, pressing),
        ):
            button.setEnabled(enabled)
        self._prompt.setText(self._error or (_IDLE if shown is None else shown.prompt))
        self._progress.setValue(0 if shown is None else shown.progress)
        self._felt.setText("–" if shown is None else shown.felt)
        self._parts.setText("–" if shown is None else shown.parts)
        if shown is None:
            return
        if going:
            self._ended = False
            if pressing:
                self._selection.mark(shown.missing, shown.pressed)
        elif not self._ended:
            self._ended = True
            self._show_result()

    def _on_folded_changed(self) -> None:
        self.refresh()

    def _show_result(self) -> None:
        found = self._with_check(lambda check: (_notes(check), verdicts_of(check).faulty))
        if found is None:
            return
        notes, faulty = found
        self._notes.show_notes(notes)
        self._selection.mark(faulty, np.zeros(0, dtype=np.int64))

    def _on_start_clicked(self) -> None:
        self._earlier = None
        self._started = datetime.now().astimezone()
        self._notes.show_notes([])
        self._error = self._try(LiveInput.begin_check)
        self.refresh()

    def _on_back_clicked(self) -> None:
        self._act(SkinCheck.back)

    def _on_skip_clicked(self) -> None:
        self._act(SkinCheck.skip)

    def _on_next_clicked(self) -> None:
        self._act(SkinCheck.next)

    def _on_finish_clicked(self) -> None:
        self._act(SkinCheck.finish)

    def _act(self, act: Callable[[SkinCheck], None]) -> None:
        self._error = self._try(lambda live: live.with_check(act))
        self.refresh()

    def save_report(self, path: str) -> None:
        """Write the report of the check; show an error in the panel."""
        facts, points = self._stated() if self._earlier is None else (self._earlier.facts, self._earlier.points)
        try:
            self._with_check(lambda check: write_check_report(check, path, facts, points=points))
        except TactileMapsError as error:
            self._error = as_sentence(str(error))
        self.refresh()

    def _with_check(self, act: Callable[[SkinCheck], T]) -> T | None:
        """Call ``act`` with the check that is shown; return its result, None without a check."""
        if self._earlier is not None:
            return act(self._earlier.check)
        return None if self._input is None else self._input.with_check(act)

    def _stated(self) -> tuple[Mapping[str, object], FloatArray]:
        """Return what the report states about the connection, and the places of the taxels on its map."""
        live = self._input
        assert live is not None
        assert self._started is not None
        source = live.connection.source.address
        facts = check_facts(live.session.prepared, source, str(live.facts()[0].unit), self._started)
        return facts, live.session.map.taxel_points

    def _keep_check(self) -> None:
        """Finish the check of the connection that is closed, and keep it if the skin at rest was measured."""
        if self._started is not None and (check := self._with_check(_finished)) is not None:
            self._earlier = _Ended(check, *self._stated())


def _finished(check: SkinCheck) -> SkinCheck | None:
    """Finish a check; return None if the skin at rest was not measured."""
    if check.stage is CheckStage.REST:
        return None
    check.finish()
    return check


class _Shown:
    """State of a check for display, copied while no reading is processed."""

    def __init__(self, check: SkinCheck) -> None:
        outcomes = [result.outcome for result in check.results]
        left = check.stage is CheckStage.DONE
        self.stage = check.stage
        done = _DONE if check.any_pressed else _UNPRESSED
        self.prompt = done if left else as_sentence(check.prompt)
        self.missing = check.missing
        self.pressed = check.pressed
        self.progress = round(1000 * (1.0 if left else check.current / max(len(check.parts), 1)))
        self.felt = f"{int(check.felt.sum())} of {len(check.skin)}"
        self.parts = f"{outcomes.count(Outcome.FELT)} of {len(outcomes)}"


def _notes(check: SkinCheck) -> list[Note]:
    """Return the result: parts without a clear response, swapped channels, and channels by fault."""
    verdicts = verdicts_of(check)
    notes = []
    for part, result in zip(check.parts, check.results, strict=True):
        if result.outcome not in (Outcome.FELT, Outcome.OPEN):
            others = f": {check.names(result.others)}" if result.others else ""
            notes.append(Note(part.name, f"{result.outcome}{others}", fault=result.outcome is not Outcome.SKIPPED))
    notes += [Note("Swapped", text, fault=True) for text in swap_texts(check, verdicts)]
    for fault, those in verdicts.faults.items():
        taxels = np.flatnonzero(those).tolist()
        if taxels:
            names = names_text(list(map(check.skin.taxel_text, taxels)), _NAMED, separator="; ")
            notes.append(Note(f"{len(taxels)} {fault}", f"{names}: {FAULT_TEXTS[fault]}", fault=True))
    if not notes and not check.any_pressed:
        notes.append(Note("Not checked", "nothing was pressed."))
    elif not notes:
        count = int(check.felt.sum())
        notes.append(Note("No faults", f"{counted(count, 'taxel')} pressed, and all respond."))
    return notes
