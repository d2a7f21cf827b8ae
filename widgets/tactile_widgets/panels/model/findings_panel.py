"""Findings from opening the scene, and the log of messages."""

from __future__ import annotations

from PySide6.QtCore import Qt, QTime
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import Finding
from tactile_maps.session.prepare import PreparedScene, findings_of
from tactile_widgets.common.note_list import Note, NoteList
from tactile_widgets.common.panel import Panel
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.jobs.later import call_later

_NO_FINDINGS = "Problems noticed or repaired while opening a robot, skin or scene are listed here."
_FAULTS = ("missing-mesh", "scene-warning")
"""Kinds of findings after which the display differs from what the files specify."""
_MOST = 200
_NO_MESSAGES = "Messages and errors are listed here; Ctrl+C copies them."


def note_of(finding: Finding) -> Note:
    """Return a finding as a note, such as ``Missing mesh, link_3.stl: Replaced by a small box``."""
    kind = finding.kind.replace("-", " ").replace("_", " ")
    times = f"{finding.count} × " if finding.count > 1 else ""
    head = f"{times}{kind}, {finding.where}" if finding.where else f"{times}{kind}"
    return Note(capitalized(head), capitalized(finding.action), fault=finding.kind in _FAULTS)


class FindingsPanel(Panel):
    """Findings of the open scene; the heading counts them."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Findings", "findings-panel", parent)
        self.list = NoteList("findings-list", "Findings", _NO_FINDINGS, self)
        self.list.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.column.addWidget(self.list)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        call_later(self.list, self.list.show_all)  # once the width is known

    def show_prepared(self, prepared: PreparedScene) -> None:
        found = findings_of(prepared)
        self.list.show_notes([note_of(finding) for finding in found])
        self.list.show_all()
        self.set_heading(f"Findings, {len(found)}" if found else "Findings")


class MessagesPanel(Panel):
    """Messages of the window, the newest on top."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Messages", "messages-panel", parent)
        self.list = NoteList("messages-list", "Messages, the newest first", _NO_MESSAGES, self)
        self.column.addWidget(self.list)

    def add(self, text: str, fault: bool) -> None:
        """Add a message with the current time; ``fault`` for an error."""
        kind = "Error" if fault else "Message"
        self.list.put_first(Note(f"{kind}, {QTime.currentTime().toString('HH:mm:ss')}", text, fault), most=_MOST)
