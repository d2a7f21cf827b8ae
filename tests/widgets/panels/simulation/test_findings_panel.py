"""Findings: everything that opening noticed is listed with what to do, and counted in the heading."""

from __future__ import annotations

from dataclasses import replace

import pytest
import trimesh

from tactile_maps.core.errors import Finding
from tactile_widgets.common.note_list import Note
from tactile_widgets.panels.model.findings_panel import FindingsPanel, MessagesPanel, note_of

MISSING = Finding("missing-mesh", "link_3.stl", "a small box is used; choose the package root", 2)


@pytest.fixture
def panel(qtbot):
    made = FindingsPanel()
    qtbot.addWidget(made)
    return made


def test_finding_is_described_in_text():
    text = "A small box is used; choose the package root"
    assert note_of(MISSING) == Note("2 × missing mesh, link_3.stl", text, fault=True)
    assert not note_of(Finding("guessed-units", "", "read as millimetres")).fault


def test_findings_of_robot_skin_and_map_are_listed(panel, prepared):
    of_map = Finding("seam-added", "hand", "cut once more")
    charts = (replace(prepared.map.charts[0], findings=(of_map,)), *prepared.map.charts[1:])
    robot = replace(prepared.robot, findings=(MISSING,))
    panel.show_prepared(replace(prepared, robot=robot, map=replace(prepared.map, charts=charts)))
    assert note_of(MISSING) in panel.list.notes
    assert note_of(of_map) in panel.list.notes
    assert panel._heading.text() == f"Findings, {len(panel.list.notes)}"
    panel.show_prepared(replace(prepared, robot=replace(robot, findings=())))
    assert note_of(MISSING) not in panel.list.notes


def test_list_of_findings_never_scrolls(panel, prepared):
    panel.resize(280, 600)
    panel.show()
    panel.show_prepared(replace(prepared, robot=replace(prepared.robot, findings=(MISSING,) * 9)))
    rows = panel.list.visualItemRect(panel.list.item(panel.list.count() - 1))
    assert panel.list.viewport().rect().contains(rows)


def test_messages_of_the_window_are_kept(window_again):
    kept = window_again.column.get(MessagesPanel).list
    window_again.notifier.say("Saved a.mcap")
    window_again.notifier.fault("The file cannot be read")
    fault, message = kept.notes[:2]
    assert (fault.text, fault.fault) == ("The file cannot be read", True)
    assert (message.text, message.fault) == ("Saved a.mcap", False)
    window_again.notification_bar.clear()


@pytest.mark.long
def test_missing_faces_of_a_mesh_are_listed_when_it_is_opened(new_window, tmp_path):
    mesh = tmp_path / "pad.obj"
    ball = trimesh.creation.icosphere(1, radius=0.05)
    ball.export(mesh)
    lines = mesh.read_text()
    mesh.write_text(f"{lines.rstrip()}\nf 1 2\nf 2 3\n")
    new_window.presenters.files.open_path(str(mesh))
    line = lines.rstrip().count("\n") + 2
    notes = new_window.column.get(FindingsPanel).list.notes
    action = f"Fewer than three corners, dropped; the first is in line {line}"
    assert Note(f"2 × short face, {mesh}", action, fault=False) in notes
