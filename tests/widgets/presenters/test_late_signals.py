"""Signals of panels while the window is deleted."""

from __future__ import annotations

import pytest
import shiboken6
from PySide6.QtWidgets import QApplication

from tactile_widgets.panels.model.accuracy_panel import AccuracyPanel
from tactile_widgets.panels.touch.simulated_skin_panel import SimulatedSkinPanel
from tactile_widgets.session.backends import INLINE
from tests.widgets.support.window_driver import close_window, open_window


@pytest.mark.long
@pytest.mark.parametrize("name", ["reference", "skin_comparison"])
def test_signal_after_its_receiver_is_deleted_is_ignored(qtbot, prepared, tmp_path, own_files, name):
    window = open_window(tmp_path, INLINE)
    window.live.show_prepared(prepared)
    QApplication.processEvents()
    panels = window.context.panels
    senders = {"reference": panels.get(AccuracyPanel).reference, "skin_comparison": panels.get(SimulatedSkinPanel)}
    receiver = getattr(window.live, name)
    executor = receiver.executor
    close_window(window)
    shiboken6.delete(receiver)
    assert not shiboken6.isValid(executor)
    senders[name].enabled_changed.emit(True)
    senders[name].enabled_changed.emit(False)
