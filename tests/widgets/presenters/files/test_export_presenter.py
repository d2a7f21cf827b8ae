"""Data out of the window: an export that is shown and can be cancelled, and a session that viewers can watch."""

from __future__ import annotations

import socket
import sys

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import ExportError
from tactile_maps.export.export import FORMATS
from tactile_widgets.dialogs.export_dialog import ExportDialog
from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.session import sharing
from tests.widgets.support.window_driver import cancel, record_run, replay_run, run


@pytest.fixture
def window(window_again):
    """Window whose export ends with the test."""
    return window_again


@pytest.fixture
def path(window, tmp_path):
    path = tmp_path / "demo.mcap"
    record_run(window, path, 0.3)
    return path


def finished(window, qtbot):
    qtbot.waitUntil(lambda: window.presenters.export._thread is None, timeout=20_000)


@pytest.mark.long
def test_recording_is_exported_in_the_background(window, qtbot, path, tmp_path):
    window.presenters.export.export(str(path), FORMATS["npz"], str(tmp_path / "out"))
    finished(window, qtbot)
    assert (tmp_path / "out.npz").is_file()
    assert "Exported" in window.notification_bar.text


@pytest.mark.long
def test_cancelled_export_leaves_no_file(window, qtbot, path, tmp_path):
    presenter = window.presenters.export
    presenter.export(str(path), FORMATS["csv"], str(tmp_path / "out"))
    cancel(window)
    finished(window, qtbot)
    assert sorted(one.name for one in tmp_path.iterdir() if "out" in one.name or "part" in one.name) in ([], ["out"])
    assert not [one for one in tmp_path.iterdir() if one.name.endswith(".part")]


def listens(port: int) -> bool:
    """Whether anything on this computer does."""
    try:
        socket.create_connection(("127.0.0.1", port), timeout=5).close()
    except ConnectionError:
        return False
    return True


def test_failed_export_shows_a_message(window, qtbot, tmp_path):
    (tmp_path / "no.mcap").write_text("nothing")
    window.presenters.export.export(str(tmp_path / "no.mcap"), FORMATS["npz"], str(tmp_path / "out"))
    finished(window, qtbot)
    assert "not a recording" in window.notification_bar.text


def test_sharing_reports_its_local_address_and_stops(window, qtbot):
    action = window.action("share_live")
    assert action.isEnabled()
    action.trigger()
    address = window.live.sharing.address
    assert address.startswith("ws://127.0.0.1:")
    assert address in window.notification_bar.text
    assert action.isChecked()
    window.notification_bar.clear()
    window.live.show_prepared(window.live.prepared)
    qtbot.waitUntil(lambda: window.live.sharing.address == address)
    assert window.notification_bar.messages == (), "once for each address"
    port = int(address.rpartition(":")[2])
    assert listens(port)
    run(window, 0.1)
    action.trigger()
    assert window.live.sharing.address is None
    assert not action.isChecked()
    qtbot.waitUntil(lambda: not listens(port))


@pytest.mark.long
def test_sharing_starts_although_its_port_is_freed_late(window, tmp_path, monkeypatch, qtbot):
    replay_run(window, tmp_path / "a.mcap", 0.1)
    window.action("share_live").trigger()
    address = window.live.sharing.address
    connect = sharing._connect
    refused = iter(range(3))

    def connect_late(kind, prepared):
        if next(refused, None) is not None:
            raise ExportError("the port is in use", place=address)
        return connect(kind, prepared)

    monkeypatch.setattr(sharing, "_connect", connect_late)
    window.live.replay.leave()
    qtbot.waitUntil(lambda: window.live.sharing.address == address)
    assert window.action("share_live").isChecked()
    assert "in use" not in window.notification_bar.text
    window.action("share_live").trigger()


def test_missing_rerun_viewer_is_reported(window):
    window.presenters.export.toggle_sharing(sharing.ViewerKind.RERUN)
    assert window.live.sharing.kind is None
    assert not window.action("share_rerun").isChecked()
    assert "rerun" in window.notification_bar.text


@pytest.mark.long
def test_range_is_exported_in_an_installed_format(window, qtbot, path, tmp_path, monkeypatch, choose_file):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    window.live.open_recording(path)
    window.timeline.set_range(Span(0.1, 0.2))
    window.action("export_recording").trigger()
    dialog = window.findChild(ExportDialog, "export-dialog")
    assert dialog.part.span == (0.1, 0.2)
    items = {
        item.data(Qt.ItemDataRole.UserRole): item for item in dialog.formats.findItems("", Qt.MatchFlag.MatchContains)
    }
    line = FORMATS["parquet"].install
    assert not items["parquet"].flags() & Qt.ItemFlag.ItemIsEnabled
    assert f"{sys.executable} -m pip install" in line
    assert line in items["parquet"].toolTip()
    assert line in dialog.note.text()
    assert not dialog.fps.isEnabled()
    dialog.formats.setCurrentItem(items["npz"])
    choose_file("save_file", tmp_path / "part.npz")
    dialog.export.click()
    finished(window, qtbot)
    with np.load(tmp_path / "part.npz") as tables:
        times = tables["frames.time_s"]
    assert times[-1] - times[0] == pytest.approx(0.1)
    window.live.replay.leave()


def test_dialog_requests_rows_per_second_of_a_lerobot_data_set(qtbot):
    pytest.importorskip("pyarrow")
    pytest.importorskip("av")
    parent = QWidget()
    qtbot.addWidget(parent)
    dialog = ExportDialog(1.0, None, parent)
    requested = []
    dialog.requested.connect(lambda *values: requested.append(values))
    items = {dialog.formats.item(row).data(Qt.ItemDataRole.UserRole): row for row in range(dialog.formats.count())}
    dialog.formats.setCurrentRow(items["lerobot"])
    assert dialog.fps.isEnabled()
    assert dialog.fps.text() == "Every reading"
    dialog.fps.setValue(10)
    dialog.export.click()
    assert requested == [("lerobot", None, 10)]


@pytest.mark.long
def test_recordings_without_viewer_messages_are_smaller(window, tmp_path):
    sizes = []
    for name in ("with.mcap", "without.mcap"):
        record_run(window, tmp_path / name, 0.3)
        sizes.append((tmp_path / name).stat().st_size)
        window.action("record_for_viewers").trigger()
    assert sizes[1] < sizes[0]
    assert window.action("record_for_viewers").isChecked()
    assert b"foxglove" not in (tmp_path / "without.mcap").read_bytes()


def test_dialog_states_when_the_recording_begins_in_the_session(window, tmp_path):
    run(window, 0.3)
    record_run(window, tmp_path / "late.mcap", 0.2)
    window.live.open_recording(tmp_path / "late.mcap")
    window.action("export_recording").trigger()
    (dialog,) = window.findChildren(ExportDialog)
    begins = window.live.replay.player.times[0]
    assert begins > 0.1
    assert f"the recording begins at {begins:.2f} s." in dialog.note.text()
    dialog.reject()
    window.live.replay.leave()
