"""The toolbar shows words where there is room, and icons where there is little; no button is lost."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLabel


@pytest.fixture
def window(window_again):
    """The module's window, of the usual size again."""
    yield window_again
    window_again.resize(1400, 900)


@pytest.mark.parametrize(("width", "worded", "named"), [(900, False, False), (1280, True, False), (1366, True, True)])
def test_toolbar_shows_texts_if_they_fit(window, width, worded, named):
    window.resize(width, 700)
    QApplication.processEvents()
    bar = window.session_bar
    assert bar.has_text == worded
    assert bar.findChild(QLabel, "toolbar-map").isVisible() == named
    text_and_icon = Qt.ToolButtonStyle.ToolButtonTextBesideIcon
    assert (bar.select.toolButtonStyle() is text_and_icon) == worded
    for name in ("pause", "step", "reset", "record", "poke", "undo", "redo"):
        button = bar.widgetForAction(window.action(name))
        assert button.isVisible(), name
        assert button.geometry().right() <= width
        assert button.accessibleName()
