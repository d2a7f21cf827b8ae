"""A known weight in the window: measured, taken back, saved; what cannot be is said in the dialog."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QPushButton

from tactile_maps.live.calibration.calibration import ValueMode
from tactile_maps.live.readings.arrival import Arrived
from tactile_maps.live.readings.readings import Reading, Unit
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.note_list import NoteList
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.session.live_input import LiveInputSettings


def test_weight_calibrates_and_can_be_undone(window, tmp_path, monkeypatch):
    window.live.connection.open(LiveInputSettings("udp://127.0.0.1:0"))
    session = window.live.live_input.session
    monkeypatch.setattr(window.live.live_input, "gap", lambda *_: None)  # readings bypass the connection
    panel = window.column.get(LiveInputPanel)
    taxels = len(window.live.prepared.skin)

    def send(time, level):
        session.show(Arrived(Reading(time, np.full(taxels, level), Unit.COUNTS), time))
        panel.refresh()

    panel.findChild(QPushButton, "live-weight").click()
    dialog = panel.weight
    state = dialog.findChild(QLabel, "weight-state")
    assert dialog.isVisible()
    assert not dialog.measure.isEnabled()
    assert "Not tared yet" in state.text()
    session.tare(1)
    send(0.0, 20.0)
    refused = tmp_path / "no such folder" / " ".join(["long name of gains"] * 10)
    panel.save_calibration(str(refused))
    QApplication.processEvents()
    assert "long name" in state.text()
    assert all(label.height() >= label.heightForWidth(label.width()) for label in dialog.findChildren(QLabel))
    dialog.measure.click()
    send(2.5, 20.0)
    assert "do not change under the weight" in state.text()
    dialog.reject()
    panel.findChild(QPushButton, "live-weight").click()
    assert state.text() == "Not calibrated."
    dialog.measure.click()
    assert "2.0\u202fs left" in state.text()
    send(5.0, 10.0)
    assert "under the weight: the gain is negative. Apply it?" in state.text()
    dialog.negative.click()
    assert "gains × -" in state.text()
    assert (session.readings.calibration.gain < 0).all()
    assert dialog.negative.isHidden()
    dialog.undo.click()
    session.readings.request_mode(ValueMode.RAW)
    dialog.measure.click()
    send(7.5, 30.0)
    assert state.text().startswith("Done: gains × ")
    assert state.text().endswith("Readings are shown as pressure, contacts in newtons.")
    values = panel.findChild(QComboBox, "live-mode")
    notes = panel.findChild(NoteList, "live-notes")
    assert values.currentText() == "Pressure (kPa)"
    assert "No forces" not in "".join(note.words for note in notes.notes)
    session.readings.request_mode(ValueMode.RAW)
    send(8.0, 30.0)
    assert "newtons" not in state.text()
    words = "".join(note.words for note in notes.notes)
    assert "Choose Pressure (kPa) under Values" in words
    assert "Not calibrated" not in words
    assert dialog.save.isEnabled()
    opened = []
    (tmp_path / "chosen").mkdir()
    path = str(tmp_path / "chosen" / "gains.csv")
    monkeypatch.setattr(FileDialog, "save_file", lambda _parent, _title, start, _kinds: opened.append(start) or path)
    dialog.save.click()
    dialog.save.click()
    assert opened == [str(tmp_path / "gains.csv"), str(tmp_path / "chosen" / "gains 2.csv")], "the folder is remembered"
    assert len(Path(path).read_text().splitlines()) == taxels + 1
    dialog.undo.click()
    assert "Not calibrated" in state.text()
    assert not dialog.save.isEnabled()
    window.views.selection.select_all()
    assert dialog.scope.text() == f"{taxels} selected taxels"
    window.live.connection.close()
    assert not dialog.isVisible()
