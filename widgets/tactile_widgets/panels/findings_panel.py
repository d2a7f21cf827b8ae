"""What opening noticed or repaired, each with what was done about it or what a person can do."""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import Finding
from tactile_maps.session.prepare import PreparedScene, findings_of
from tactile_widgets.common.panel import Panel
from tactile_widgets.panels.note_list import Note, NoteList

_HEIGHT = 120
_EMPTY = "What opening a robot, skin or scene noticed or repaired is listed here."
_FAULTS = ("missing-mesh", "scene-warning")
"""Kinds after which what is shown is not what was meant."""


def note_of(finding: Finding) -> Note:
    """``Missing mesh, link_3.stl: a small box stands in``."""
    kind = finding.kind.replace("-", " ").replace("_", " ")
    times = f"{finding.count} × " if finding.count > 1 else ""
    head = f"{times}{kind}, {finding.where}" if finding.where else f"{times}{kind}"
    action = f"{finding.action[:1].upper()}{finding.action[1:]}"
    return Note(f"{head[:1].upper()}{head[1:]}", action, fault=finding.kind in _FAULTS)


class FindingsPanel(Panel):
    """Lists them; its heading says how many there are."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Findings", "findings-panel", parent)
        self.list = NoteList("findings-list", _EMPTY, _HEIGHT, self)
        self.list.setAccessibleName("Findings")
        self.column.addWidget(self.list)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Another scene."""
        found = findings_of(prepared)
        self.list.show_notes([note_of(finding) for finding in found])
        self.set_heading(f"Findings, {len(found)}" if found else "Findings")
