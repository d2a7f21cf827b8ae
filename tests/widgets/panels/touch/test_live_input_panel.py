"""The live input panel: how readings arrive, in words; tare, values shown, disconnect."""

from __future__ import annotations

import re

import pytest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QPushButton

from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.recording.player import open_recording
from tactile_widgets.panels.control.behaviours_panel import BehavioursPanel
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.model.effects_panel import EffectsPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel
from tactile_widgets.session.live_input import LiveInputSettings
from tests.widgets.support.window_driver import run

TABLE = "time,sequence,{}\n" + "".join(f"{0.01 * i},{i}{{}}\n" for i in (0, 1, 3, 4, 5))


@pytest.fixture
def window(window_again):
    """What was connected is disconnected again by each test."""
    return window_again


def connected(window, tmp_path, **settings):
    taxels = len(window.live.prepared.skin)
    path = tmp_path / "readings.csv"
    path.write_text(TABLE.format(",".join(map(str, range(taxels + 1))), *[",20" * (taxels + 1)] * 5))
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None), **settings))
    panel = window.column.get(LiveInputPanel)
    for _ in range(60):
        run(window, 0.2)
    panel.refresh()
    return panel


def text(panel, name):
    return panel.findChild(QLabel, f"live-{name}").text()


@pytest.mark.long
def test_it_is_there_while_something_is_connected(window, tmp_path):
    panel = window.column.get(LiveInputPanel)
    assert panel.isHidden()
    assert not window.action("disconnect").isEnabled()
    connected(window, tmp_path)
    assert panel.isVisible()
    assert window.action("disconnect").isEnabled()
    panel.findChild(QPushButton, "live-disconnect").click()
    assert panel.isHidden()
    assert window.live.live_input is None


def test_it_tells_how_readings_arrive(window, tmp_path):
    panel = connected(window, tmp_path)
    assert text(panel, "counts") == "5"
    assert text(panel, "loss") == "17\u202f%"
    assert text(panel, "taxels") == "150 of 150"
    notes = text(panel, "notes")
    assert "does not have: 150" in notes
    assert "no forces are shown" in notes
    window.live.connection.close()


@pytest.mark.long
def test_no_simulated_finger_is_offered_on_a_real_skin(window, tmp_path):
    contacts = window.column.get(ContactsPanel)
    run(window, 0.1)
    assert contacts.fingers.isVisible()
    connected(window, tmp_path)
    assert contacts.fingers.isHidden()
    choice = contacts.reading.threshold
    assert choice.words.startswith("Automatic threshold ≥ ")
    assert choice.fontMetrics().horizontalAdvance(choice.words) < choice.width() - 28, "not cut before the arrow"
    contacts.clear()
    assert contacts.findChild(QLabel, "contacts-summary").text() == "No contact."
    window.live.connection.close()
    run(window, 0.1)
    assert contacts.fingers.isVisible()


def test_it_fits_the_column_with_much_trouble(window, tmp_path):
    panel = connected(window, tmp_path)
    counts = (f"{12345} {name}" for name in ("malformed", "duplicated", "reordered", "late", "restarts", "refused"))
    panel.findChild(QLabel, "live-trouble").setText(", ".join(counts))
    QApplication.sendPostedEvents()  # lay out, without a refresh by the panel's timer
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to it"
    window.live.connection.close()


def _told(window):
    """All that is said of how hard the skin is touched."""
    contacts = window.column.get(ContactsPanel)
    texts = [window.views.bar.title, *(label.text() for label in contacts.findChildren(QLabel))]
    texts += [mark.text for mark in window.views.map.marks.contacts]
    texts += [window.plots._force._plot.heading, window.plots._pressure._plot.heading]
    texts.append(window.views.map.words_for(window.live.prepared.skin.taxel_point(3)))
    return [text.replace("\u202f", " ") for text in texts]


@pytest.mark.long
def test_counts_are_never_called_pressure_or_force(window, tmp_path):
    connected(window, tmp_path)
    window.live.recording.start(tmp_path / "felt.mcap")
    window.live.recording.stop()
    told = _told(window)
    assert "Reading (counts)" in told
    assert window.status_line.factor.text().endswith("\u202fHz")
    assert not any(line.box.isEnabled() for line in window.column.get(EffectsPanel).lines.values())
    for kind in (ControllerPanel, BehavioursPanel, EffectsPanel):
        panel = window.column.get(kind)
        assert panel.isEnabled() == (kind is EffectsPanel)
        assert any("disconnect it" in label.text() for label in panel.findChildren(QLabel))
    assert any("force unknown" in text for text in told)
    assert any(re.search(r"\d counts", text) for text in told)
    window.live.show_player(open_recording(tmp_path / "felt.mcap"))
    run(window, 0.1)
    for text in [*told, *_told(window)]:
        assert not re.search(r"\bkPa\b|\bN\b", text), text
    window.live.replay.leave()
    window.live.connection.close()
    run(window, 0.3)
    assert "Pressure (kPa)" in _told(window)
    assert "real time" in window.status_line.factor.text()
    assert window.column.get(ControllerPanel).isEnabled()
    assert not any("disconnect it" in label.text() for label in window.column.findChildren(QLabel) if label.isVisible())


def test_pressure_without_a_calibration_is_refused_in_place_and_tare_is_asked_for(window, tmp_path):
    panel = connected(window, tmp_path)
    modes = panel.findChild(QComboBox, "live-mode")
    modes.activated.emit(2)
    assert "cannot be shown as pressure" in text(panel, "notes")
    assert modes.currentText() == "Above the baseline"
    modes.activated.emit(0)
    assert modes.currentText() == "Raw"
    tare = panel.findChild(QPushButton, "live-tare")
    tare.click()
    assert tare.text() == "Taring…"
    assert not tare.isEnabled()
    window.live.connection.close()
