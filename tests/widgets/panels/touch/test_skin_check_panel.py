"""The panel of the guided check: parts to press are selected, keys move on, the result is listed and saved."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtWidgets import QLabel, QPushButton

from tactile_maps.live.checking.parts import parts_of
from tactile_maps.live.sources.open import SourceOptions
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.note_list import NoteList
from tactile_widgets.document.taxel_selection import TAXEL_COLOURS
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tactile_widgets.panels.touch.skin_check_panel import SkinCheckPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tests.support.pressed_stream import RATE, pressed


@pytest.fixture
def window(window_again):
    """The shared window; the connection is closed after each test."""
    yield window_again
    window_again.live.connection.close()


def connected(window, tmp_path, touches, dead):
    """Connect to a skin whose touches begin 5 s after the start, and unfold the panel."""

    def change(values, number):
        values[dead] = 200.0
        return values

    skin = window.live.prepared.skin
    rows = [f"{time}," + ",".join(map(str, values)) for values, time in pressed(skin, touches, change=change, rest=5.0)]
    path = tmp_path / "readings.csv"
    path.write_text("\n".join(["time," + ",".join(map(str, range(len(skin)))), *rows]))
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None)))
    panel = window.column.get(SkinCheckPanel)
    panel.set_folded(False)
    return panel


def press(panel, name):
    panel.findChild(QPushButton, f"check-{name}").click()


def prompt(panel):
    return panel.findChild(QLabel, "check-prompt").text()


def seconds(window, count):
    """Take the readings of so many seconds of the stream: one in each pass of 0.05 s."""
    assert RATE == 20.0
    window.live.runner.run_for(count)
    window.live.pump()


def test_parts_are_highlighted_until_they_respond_and_the_result_is_listed_and_saved(window, tmp_path, monkeypatch):
    skin = window.live.prepared.skin
    parts = parts_of(skin)
    first = parts[0].taxels
    half = first[: len(first) // 2]
    dead = int(parts[1].taxels[len(parts[1].taxels) // 2])
    panel = connected(window, tmp_path, [half, first[len(half) :], parts[1].taxels], dead)
    press(panel, "start")
    assert prompt(panel) == "Leave the skin untouched for 2 s"
    seconds(window, 2.5)
    panel.refresh()
    press(panel, "finish")
    assert prompt(panel).startswith("Done, but nothing was pressed")
    assert [note.words for note in panel.findChild(NoteList, "check-notes").notes] == [
        "Not checked: nothing was pressed."
    ]
    press(panel, "start")
    seconds(window, 2.4)
    panel.refresh()
    selection = window.views.selection
    assert prompt(panel) == f"Press {parts[0].name} (1 of {len(parts)})"
    assert selection.taxels.tolist() == first.tolist()
    seconds(window, 1.2)
    panel.refresh()
    assert f"{len(first) - len(half)} of {len(first)} taxels are not felt yet" in prompt(panel)
    assert {int(t) for t, ink in zip(selection.taxels, selection.inks, strict=True) if ink == TAXEL_COLOURS[2]} == {
        *half.tolist()
    }
    seconds(window, 8.0)
    panel.refresh()
    assert prompt(panel).startswith(f"Press {parts[2].name}")
    press(panel, "skip")
    press(panel, "next")
    press(panel, "back")
    assert prompt(panel).endswith(f"Press {parts[3].name} (4 of {len(parts)})")
    press(panel, "finish")
    assert panel.findChild(QLabel, "check-parts").text() == f"2 of {len(parts)}"
    notes = [note.words for note in panel.findChild(NoteList, "check-notes").notes]
    assert f"{parts[2].name}: skipped" in notes
    assert any(note.startswith(f"1 dead: taxel {dead}: no response") for note in notes)
    assert window.live.live_input.facts()[0].tared
    assert dead in selection.taxels
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8
    (tmp_path / "chosen").mkdir()
    report = tmp_path / "chosen" / "skin.html"
    opened = []
    monkeypatch.setattr(
        FileDialog, "save_file", lambda _parent, _title, start, _kinds: opened.append(start) or str(report)
    )
    press(panel, "save")
    press(panel, "save")
    assert opened == [str(tmp_path / "skin check.html"), str(report.with_stem("skin 2"))], "the folder is remembered"
    assert "1 dead" in report.read_text(encoding="utf8")
    assert np.array_equal(selection.taxels, np.sort(selection.taxels))
    page = report.read_text(encoding="utf8")
    report.unlink()
    window.live.connection.close()
    panel = connected(window, tmp_path, [], 0)
    assert [note.words for note in panel.findChild(NoteList, "check-notes").notes] == notes
    assert not panel.findChild(QPushButton, "check-back").isEnabled(), "no reading can follow"
    press(panel, "save")
    assert report.read_text(encoding="utf8") == page, "the result is kept until another check begins"
    press(panel, "start")
    assert not panel.findChild(QPushButton, "check-save").isEnabled()


@pytest.mark.long
def test_check_cannot_be_finished_at_rest_and_is_reset_by_a_new_connection(window, tmp_path):
    panel = connected(window, tmp_path, [], 0)
    press(panel, "start")
    seconds(window, 0.2)
    panel.refresh()
    assert not panel.findChild(QPushButton, "check-finish").isEnabled()
    assert not panel.findChild(QPushButton, "check-start").isEnabled()
    window.live.connection.close()
    panel = connected(window, tmp_path, [], 0)
    assert panel.findChild(QPushButton, "check-start").isEnabled()
    assert "one after another" in prompt(panel)


@pytest.mark.long
def test_check_that_a_closed_connection_ended_is_kept_for_its_skin(window, tmp_path):
    panel = connected(window, tmp_path, [], 0)
    press(panel, "start")
    seconds(window, 2.4)
    window.live.connection.close()
    panel = connected(window, tmp_path, [], 0)
    assert prompt(panel).startswith("Done")
    assert panel.findChild(QPushButton, "check-save").isEnabled()
    window.live.connection.close()
    window.presenters.files.open_robot("slide")
    panel = connected(window, tmp_path, [], 0)
    assert "one after another" in prompt(panel)
