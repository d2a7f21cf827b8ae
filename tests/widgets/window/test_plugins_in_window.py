"""Plug-ins in the window: in its lists and menus, at a drop on it, and in the process that prepares a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QInputDialog, QMessageBox

from tactile_widgets.session.backends import INLINE
from tests.support.plugins import install_example
from tests.widgets.support.executors import in_process
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import answer, run


@pytest.fixture
def backends(tmp_path, monkeypatch):
    """Plug-ins are installed before the window is there; scenes are prepared in a process."""
    install_example(tmp_path / "site", monkeypatch)
    return replace(INLINE, executor=in_process("prepare"))


def drop(window, path):
    """Drop a file with the events of Qt: it enters, the window accepts it, and it is released."""
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(path))])
    how = (Qt.DropAction.CopyAction, data, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier)
    enter = QDragEnterEvent(QPoint(400, 400), *how)
    QApplication.sendEvent(window, enter)
    assert enter.isAccepted()
    QApplication.sendEvent(window, QDropEvent(QPointF(400, 400), *how))


def test_plugins_are_chosen_dropped_and_used_by_processes(window, qtbot, tmp_path):
    panel = window.column["controller"]
    left_click(panel._buttons["slack"])
    run(window, 0.1)
    assert window.live.runner.session.settings.controller == "slack"
    assert window.action("controller_slack").isChecked()
    window.action("controller_gentle").trigger()
    assert panel._buttons["gentle"].isChecked()
    line = window.column["effects"].lines["hum"]
    line.box.activated.emit(line.box.findData("on"))
    run(window, 0.2)
    assert [effect.name for effect in window.live.runner.session.effects.sensor.plug_ins] == ["hum"]
    path = tmp_path / "pad.xyz"
    x, y = np.meshgrid(np.arange(8), np.arange(5))
    np.savetxt(path, np.stack([4 * x.ravel(), 4 * y.ravel(), np.zeros(40)], axis=1))
    drop(window, path)
    box = window.findChild(QInputDialog, "taxel-link")
    assert box is not None, window.notification_bar.text
    box.setTextValue("No robot: the skin alone")
    box.accept()
    with qtbot.waitSignal(window.live.prepared_changed, timeout=60_000):
        answer(window, QMessageBox.StandardButton.Discard)  # the chosen controller is not saved
    assert len(window.live.prepared.skin) == 40
