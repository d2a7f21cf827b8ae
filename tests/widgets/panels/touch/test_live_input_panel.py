"""The live input panel: how readings arrive, in words; tare, values shown, disconnect."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QLabel, QPushButton

from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.live.readings.arrival import ArrivalCounts, Delay
from tactile_maps.live.session.connection import ConnectionState, ConnectionStatus
from tactile_maps.live.sources.open import SourceOptions
from tactile_maps.recording.player import open_recording
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.note_list import NoteList
from tactile_widgets.panels.control.behaviours_panel import BehavioursPanel
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.model.effects_panel import EffectsPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tactile_widgets.panels.touch.contacts_panel import ContactsPanel
from tactile_widgets.panels.touch.live_input_panel import LiveInputPanel, _texts, _troubles
from tactile_widgets.session.live_input import LiveInputSettings
from tests.support.touch import arm
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import run


@pytest.fixture
def window(window_again):
    """The shared window; each test closes its connection."""
    return window_again


def connected(window, tmp_path, values=(20, 20, 20, 20, 20), **settings):
    """Connect to readings of equal values, of which the third packet was lost, and take all of them."""
    panel = opened(
        window, tmp_path, [(number + (number > 1), value) for number, value in enumerate(values)], **settings
    )
    run_readings(window, 240)
    run(window, 0.2)
    panel.refresh()
    return panel


def opened(window, tmp_path, rows, **settings):
    """Connect to readings with (number, value of each taxel)."""
    taxels = len(window.live.prepared.skin)
    path = tmp_path / "readings.csv"
    lines = [f"time,sequence,{','.join(map(str, range(taxels + 1)))}"]
    lines += [f"{0.01 * number},{number}{f',{value}' * (taxels + 1)}" for number, value in rows]
    path.write_text("\n".join(lines) + "\n")
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None), **settings))
    return window.column.get(LiveInputPanel)


def text(panel, name):
    return panel.findChild(QLabel, f"live-{name}").text()


def notes_of(panel):
    return "\n".join(note.words for note in panel.findChild(NoteList, "live-notes").notes)


@pytest.mark.long
def test_panel_is_visible_while_connected(window, tmp_path):
    panel = window.column.get(LiveInputPanel)
    assert panel.isHidden()
    assert not window.action("disconnect").isEnabled()
    connected(window, tmp_path)
    assert panel.isVisible()
    assert window.action("disconnect").isEnabled()
    panel.findChild(QPushButton, "live-disconnect").click()
    assert panel.isHidden()
    assert window.live.live_input is None


@pytest.mark.long
def test_panel_shows_the_arrival_of_readings(window, tmp_path):
    panel = connected(window, tmp_path)
    assert text(panel, "counts") == "5"
    assert text(panel, "loss") == "17\u202f%"
    assert text(panel, "taxels") == "150 of 150"
    notes = notes_of(panel)
    assert "Taxels that the skin does not have: 150" in notes
    assert "no forces are shown" in notes
    window.live.connection.close()


def test_statistics_of_the_arrival_have_units():
    counts = ArrivalCounts(received=97, lost=3, late=1)
    status = ConnectionStatus(
        ConnectionState.RECONNECTING, "udp://:9870", counts, 99.6, Delay(0.0104, 2.0, 3.0), reconnects=2, next_try=1.5
    )
    facts = SimpleNamespace(readings=96, refused=4, unheard=10, mistimed=0, combined=0)
    assert _troubles(status, facts) == ["4\u00a0rejected", "1\u00a0late", "2\u00a0reconnects"]
    assert _texts(status, facts, None, 150) == {
        "state": "Reconnecting in 1.5\u202fs",
        "rate": "100\u202fHz",
        "delay": "10.4, 2000.0\u202fms",
        "loss": "4\u202f%",
        "counts": "96",
        "taxels": "140 of 150",
    }


@pytest.mark.long
def test_values_that_fall_are_noted_and_become_contacts_by_the_button(window, tmp_path):
    values = [2000] * 5 + [1900] * 10
    panel = connected(window, tmp_path, values, tare=3)
    button = panel.findChild(QPushButton, "live-inverted")
    assert (button.text(), button.property("role")) == ("No", "requested")
    assert "press Inverted" in notes_of(panel)
    assert not window.live.live_input.session.frame.regions
    button.click()
    assert (button.text(), button.property("role"), button.isChecked()) == ("Yes", "", True)
    assert "press Inverted" not in notes_of(panel)
    assert window.live.live_input.session.readings.inverted
    window.live.connection.close()
    panel = connected(window, tmp_path, values, tare=3, inverted=True)
    assert button.isChecked()
    assert "press Inverted" not in notes_of(panel)
    assert window.live.live_input.session.frame.regions
    window.live.connection.close()


def test_distribution_shows_the_threshold_and_sets_it(window, tmp_path):
    """Values of 2,000 and 2,030 counts in turn: a standard deviation of 15, of which 20 readings give 16."""
    panel = connected(window, tmp_path, [2000 + 30 * (number % 2) for number in range(22)] + [2300], tare=20)
    shown = panel.distribution
    caption = shown.findChild(QLabel, "distribution-caption").text()
    assert caption.startswith("150 of 150 taxels at or above the threshold.\nNoise 16")
    assert shown.view.counts.sum() == 150
    session = window.live.live_input.session
    usual = session.levels.thresholds[0]
    assert (shown.factor.isVisible(), shown.level.isVisible(), shown.factor.value()) == (True, False, 3.0)
    shown.factor.setValue(60.0)
    run(window, 0.1)
    panel.refresh()
    assert session.runtime_settings.reading.above_noise == 60.0
    assert session.levels.thresholds[0] == pytest.approx(20 * usual)
    assert shown.findChild(QLabel, "distribution-caption").text().startswith("0 of 150")
    shown.kind.setCurrentIndex(1)
    shown.kind.activated.emit(1)
    assert shown.level.isVisible()
    shown.level.setValue(250.0)
    run(window, 0.1)
    panel.refresh()
    assert (session.levels.thresholds == 250e3).all()
    assert shown.findChild(QLabel, "distribution-caption").text().startswith("150 of 150")
    assert window.column.get(ContactsPanel).reading.threshold.words == "Contact threshold 250\u202fcounts"
    shown.kind.activated.emit(0)
    run(window, 0.1)
    assert session.runtime_settings.reading.threshold is None
    window.live.set_reading(ReadingSettings())
    window.live.connection.close()


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


def test_as_many_troubles_are_named_as_fit(window, tmp_path):
    panel = connected(window, tmp_path)
    label = panel.findChild(QLabel, "live-trouble")
    names = ("rejected", "malformed", "duplicated", "reordered", "late", "restarts", "superseded")
    troubles = [f"{12345}\u00a0{name}" for name in names]
    for _ in range(2):  # as often as it is shown
        panel._show_troubles(troubles)
        assert label.text().startswith(", ".join(troubles[:2]))
        assert label.heightForWidth(label.width()) <= label.height()
        assert label.toolTip() == ", ".join(troubles)
        named = label.text().count(",")
        assert label.text().endswith(f"+\u202f{len(troubles) - named}\u00a0more")
    QApplication.sendPostedEvents()  # lay out, without a refresh by the panel's timer
    assert panel.minimumSizeHint().width() <= COLUMN_WIDTH - 8, "a scroll bar must fit next to it"
    panel._show_troubles(troubles[:1])
    assert (label.text(), label.toolTip()) == (troubles[0], "")
    window.live.connection.close()


def _touch_texts(window):
    """Return all texts about the intensity of a touch."""
    contacts = window.column.get(ContactsPanel)
    texts = [window.views.bar.title, *(label.text() for label in contacts.findChildren(QLabel))]
    texts += [mark.text for mark in window.views.map.marks.contacts]
    texts += [window.plots._force._plot.heading, window.plots._pressure._plot.heading]
    texts.append(window.views.map.words_for(window.live.prepared.skin.taxel_point(3)))
    return [text.replace("\u202f", " ") for text in texts]


@pytest.mark.long
def test_counts_are_never_labelled_as_pressure_or_force(window, tmp_path):
    connected(window, tmp_path, (0, 0, 20, 20, 20), tare=2)
    window.live.recording.start(tmp_path / "felt.mcap")
    window.live.recording.stop()
    texts = _touch_texts(window)
    assert "Reading (counts)" in texts
    assert window.status_line.factor.text().endswith("\u202fHz")
    assert not any(line.box.isEnabled() for line in window.column.get(EffectsPanel).lines.values())
    for kind in (ControllerPanel, BehavioursPanel, EffectsPanel):
        panel = window.column.get(kind)
        if kind is not EffectsPanel:
            assert not any(button.isEnabled() for button in panel.findChildren(QPushButton))
        assert any("disconnect it" in label.text() for label in panel.findChildren(QLabel))
    assert any("force unknown" in text for text in texts)
    assert any(re.search(r"\d counts", text) for text in texts)
    window.live.show_player(open_recording(tmp_path / "felt.mcap"))
    run(window, 0.1)
    window.column.get(LiveInputPanel).refresh()
    assert window.status_line.factor.text() == "Replay"
    for text in [*texts, *_touch_texts(window)]:
        assert not re.search(r"\bkPa\b|\bN\b", text), text
    window.live.replay.leave()
    window.live.connection.close()
    run(window, 0.3)
    assert "Pressure (kPa)" in _touch_texts(window)
    assert "real time" in window.status_line.factor.text()
    assert window.column.get(ControllerPanel).findChild(QPushButton, "controller-qp").isEnabled()
    assert not any("disconnect it" in label.text() for label in window.column.findChildren(QLabel) if label.isVisible())


def test_pressure_without_calibration_is_rejected_in_the_panel_and_tare_is_offered(window, tmp_path):
    panel = opened(window, tmp_path, [(number, 20) for number in range(90)])
    run_readings(window, 20)
    panel.refresh()
    modes = panel.findChild(QComboBox, "live-mode")
    modes.activated.emit(2)
    assert "cannot be shown as pressure" in notes_of(panel)
    assert modes.currentText() == "Above the baseline"
    modes.activated.emit(0)
    assert modes.currentText() == "Raw"
    tare = panel.findChild(QPushButton, "live-tare")
    tare.click()
    assert tare.text() == "Taring…"
    assert not tare.isEnabled()
    window.live.connection.close()


def run_readings(window, count):
    """Take readings, and show the last one."""
    window.live.runner.run_for(0.05 * count)
    window.live.pump()


def places(window):
    """Return the place of each visible button and list in the tab of the live input."""
    QApplication.processEvents()
    parts = [*window.column.findChildren(QPushButton), *window.column.findChildren(NoteList)]
    return {part.objectName(): part.mapTo(window.column, QPoint(0, 0)) for part in parts if part.isVisible()}


def test_no_contact_is_detected_before_the_tare_and_rows_keep_their_place(window, tmp_path):
    rows = [(number, 20 + 60 * (number >= 90)) for number in range(120)]
    panel = opened(window, tmp_path, rows)
    tare = panel.findChild(QPushButton, "live-tare")
    run_readings(window, 20)
    panel.refresh()
    before = places(window)
    assert window.live.shown.pressures.max() > 0, "readings arrive"
    assert window.live.shown.regions == ()
    assert "until then no contact is detected" in text(panel, "baseline")
    baseline = panel.findChild(QLabel, "live-baseline")
    assert baseline.heightForWidth(baseline.width()) <= baseline.height(), "the whole text is shown"
    address = panel.findChild(QLabel, "live-address")
    assert address.text().endswith("readings.csv")
    assert address.height() >= address.fontMetrics().height()
    assert tare.property("role") == "requested"
    left_click(tare)
    run_readings(window, 100)
    panel.refresh()
    assert text(panel, "baseline") == "Tared."
    assert tare.property("role") != "requested"
    assert window.live.shown.regions
    assert places(window) == before
    window.live.connection.close()


@pytest.mark.long
def test_channels_are_counted_and_listed_on_request(window, tmp_path):
    """Every fifth channel is constant for six seconds, while all others vary; one is stuck and two are not heard."""
    taxels = len(window.live.prepared.skin)
    values = np.random.default_rng(0).integers(0, 40, (600, taxels))
    values[:, ::5] = 7
    values[:, 50] = 99
    sent = np.delete(np.arange(taxels), [11, 102])
    path = tmp_path / "readings.csv"
    lines = [f"time,{','.join(map(str, sent))}"]
    lines += [f"{0.01 * number},{','.join(map(str, row))}" for number, row in enumerate(values[:, sent].tolist())]
    path.write_text("\n".join(lines) + "\n")
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None)))
    panel = window.column.get(LiveInputPanel)
    run_readings(window, 600)
    panel.refresh()
    before = places(window)
    button = panel.findChild(QPushButton, "live-channels")
    count = int(button.text().removeprefix("2 not heard, ").removesuffix(" broken"))
    assert taxels // 6 < count <= taxels // 5
    assert "Broken" not in notes_of(panel)
    left_click(button)
    listed = notes_of(panel)
    assert "Not heard: taxel 11, taxel 102" in listed
    assert listed.count("Broken: taxel ") == count
    assert listed.count(": dead at 7") == count - 1
    assert "Broken: taxel 50: stuck at 99" in listed
    assert places(window) == before
    left_click(button)
    window.resize(1366, 600)
    QApplication.processEvents()
    notes = panel.findChild(NoteList)
    shown = notes.viewport()
    assert shown.visibleRegion().boundingRect().height() < shown.height()
    left_click(button)
    QApplication.processEvents()
    assert shown.visibleRegion().boundingRect().height() == shown.height(), "the list is scrolled into view"
    assert notes.notes[notes.indexAt(QPoint(5, 5)).row()].head == "Not heard"
    left_click(button)
    window.live.connection.close()


@pytest.mark.long
def test_only_contacts_are_outlined_on_noisy_readings(window, tmp_path):
    """Noise of 1 count, which is shown as 1 kPa, the pressure of touch."""
    window.live.show_prepared(arm())
    map_ = window.live.prepared.map
    skin = map_.skin
    apart = np.linalg.norm(map_.taxel_points - map_.taxel_points[30], axis=1)
    bump = 100.0 * np.exp(-0.5 * (apart / 0.012) ** 2)
    random = np.random.default_rng(0)
    rows = [200 + random.normal(0, 1, len(skin)) + bump * (number >= 60) for number in range(65)]
    path = tmp_path / "noisy.csv"
    lines = [",".join(map(str, ("time", *range(len(skin)))))]
    lines += [",".join(map(str, (0.01 * number, *row))) for number, row in enumerate(rows)]
    path.write_text("\n".join(lines) + "\n")
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None), tare=50))
    run_readings(window, 65)
    run(window, 0.05)
    frame = window.live.live_input.session.frame
    (region,) = frame.regions
    picture = window.map_view.picture
    drawn = np.array([[line.x1(), line.y1()] for line in picture.layers["contours"].marks])
    assert len(drawn) > 5
    apart = np.linalg.norm(drawn[:, None] - picture.shapes.taxels, axis=2)
    assert np.isin(apart.argmin(axis=1), region.taxels).all()
    window.live.connection.close()


def test_readings_of_a_file_that_wait_are_counted(window, tmp_path):
    panel = opened(window, tmp_path, [(number, 20) for number in range(4)])
    for _ in range(6):
        window.live.live_input.connection.step(0.0)
    panel.refresh()
    assert (text(panel, "state"), text(panel, "counts")) == ("Receiving", "0, 4 wait")
    for _ in range(4):
        run(window, 0.05)
    panel.refresh()
    assert (text(panel, "state"), text(panel, "counts")) == ("Ended", "4")
    window.live.connection.close()


@pytest.mark.parametrize("by_key", [False, True])
def test_tare_returns_the_focus_so_that_space_pauses(window, tmp_path, by_key):
    panel = opened(window, tmp_path, [(number, 20) for number in range(90)])
    run_readings(window, 20)
    panel.refresh()
    window.map_view.setFocus()
    tare = panel.findChild(QPushButton, "live-tare")
    if by_key:
        tare.setFocus()
        QTest.keyClick(tare, Qt.Key.Key_Space)
    else:
        left_click(tare)
    QApplication.processEvents()
    assert not tare.isEnabled()
    assert window.focusWidget() is window.map_view
    windows = QApplication.topLevelWidgets()
    QTest.keyClick(window.focusWidget(), Qt.Key.Key_Space)
    assert not [made for made in QApplication.topLevelWidgets() if made.isVisible() and made not in windows]
    assert window.live.mode is Mode.PAUSED
    window.action("pause").trigger()
    window.live.connection.close()


def test_source_that_ends_before_the_tare_says_so(window, tmp_path):
    panel = connected(window, tmp_path, (20,), tare=5)
    button = panel.findChild(QPushButton, "live-tare")
    assert (button.text(), button.isEnabled()) == ("Tare", False)
    assert text(panel, "baseline") == "Not tared: the source ended after 1 reading."
    window.live.connection.close()


def test_skin_without_a_value_is_not_said_to_work(window, tmp_path):
    panel = opened(window, tmp_path, [(0, 20)])
    panel.refresh()
    button = panel.findChild(QPushButton, "live-channels")
    assert (text(panel, "taxels"), button.text()) == ("0 of 150", "None heard")
    window.live.connection.close()


def test_click_on_channels_that_all_work_says_so(window, tmp_path):
    panel = connected(window, tmp_path)
    button = panel.findChild(QPushButton, "live-channels")
    assert button.text() == "All work"
    assert "All channels work" not in notes_of(panel)
    left_click(button)
    assert "All channels work: None is broken" in notes_of(panel)
    left_click(button)
    assert "All channels work" not in notes_of(panel)
    window.live.connection.close()


@pytest.mark.parametrize(("columns", "noted"), [(112, True), (113, False)])
def test_readings_of_fewer_than_three_quarters_of_the_taxels_are_questioned(window, tmp_path, columns, noted):
    assert len(window.live.prepared.skin) == 150
    path = tmp_path / "other.csv"
    rows = [f"{0.01 * number}{',20' * columns}" for number in range(25)]
    path.write_text("\n".join([f"time,{','.join(map(str, range(columns)))}", *rows]) + "\n")
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None)))
    panel = window.column.get(LiveInputPanel)
    run_readings(window, 19)
    panel.refresh()
    assert "without a value" not in notes_of(panel)
    run(window, 0.05)
    panel.refresh()
    words = f"Taxels without a value: The readings have values of only {columns} of the skin's 150 taxels. They may be"
    assert (words in notes_of(panel)) is noted
    button = panel.findChild(QPushButton, "live-channels")
    assert button.text() == f"{150 - columns} not heard"
    assert "Not heard" not in notes_of(panel)
    left_click(button)
    assert f"Not heard: taxel {columns}, taxel {columns + 1}, " in notes_of(panel)
    left_click(button)
    window.live.connection.close()


def test_troubles_are_counted_with_singular_and_plural(window, tmp_path):
    """Two restarts of the sender's count, of which the second one repeats a packet."""
    panel = connected(window, tmp_path, (20,) * 5)
    assert text(panel, "trouble") == "None"
    window.live.connection.close()
    numbers = [5000, 5001, 5002, 10, 11, 12, 12]
    path = tmp_path / "restarted.csv"
    taxels = len(window.live.prepared.skin)
    rows = [f"{0.01 * place},{number}{',20' * taxels}" for place, number in enumerate(numbers)]
    path.write_text("\n".join([f"time,sequence,{','.join(map(str, range(taxels)))}", *rows]) + "\n")
    window.live.connection.open(LiveInputSettings(str(path), SourceOptions(speed=None)))
    run(window, 2.0)
    panel.refresh()
    label = panel.findChild(QLabel, "live-trouble")
    assert re.fullmatch(r"(1\xa0\w+, )?1\xa0restart", label.text())
    assert label.wordWrap()
    window.live.connection.close()
