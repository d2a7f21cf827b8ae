"""A theme dresses the whole application, Qt's own file dialog too."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest
from PySide6.QtCore import QEvent, QObject
from PySide6.QtGui import QColor, QImage, QPalette
from PySide6.QtWidgets import QDialog, QPushButton, QWidget

from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.common.dialog_icons import dialog_icons, dock_icons


@pytest.fixture
def app_as_before(qapp):
    style = qapp.style().objectName()
    palette = qapp.palette()
    font = qapp.font()
    sheet = qapp.styleSheet()
    yield qapp
    qapp.setStyleSheet(sheet)
    qapp.setStyle(style)
    qapp.setPalette(palette)
    qapp.setFont(font)


@pytest.mark.long
@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_theme_applies_to_the_whole_application(app_as_before, theme):
    apply_theme(app_as_before, theme)
    palette = app_as_before.palette()
    assert palette.color(QPalette.ColorRole.Window) == QColor(theme.panel)
    assert palette.color(QPalette.ColorRole.WindowText) == QColor(theme.text)
    assert app_as_before.font().pixelSize() == 13
    assert theme.line in app_as_before.styleSheet()


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_icons_of_file_dialogs_and_docks_have_the_text_colour(qapp, theme):
    icons = dialog_icons(theme) | dock_icons(theme)
    assert "titlebar-close-icon" in icons
    for name, path in icons.items():
        fine = QImage(str(Path(path).with_stem(f"{Path(path).stem}@2x")))
        assert (fine.width(), QImage(path).width()) == (32, 16), name
        pixels = [fine.pixelColor(x, y) for x in range(32) for y in range(32)]
        full = {pixel.name() for pixel in pixels if pixel.alpha() > 250}
        assert full == {QColor(theme.text).name()}, name


class StyleChanges(QObject):
    """Counts how often each widget is dressed."""

    def __init__(self):
        super().__init__()
        self.of = Counter()

    def eventFilter(self, watched, event):
        if event.type() is QEvent.Type.StyleChange:
            self.of[watched.objectName()] += 1
        return False


def test_theme_change_styles_every_widget_once(app_as_before, qtbot):
    window = QWidget(objectName="0")
    qtbot.addWidget(window)
    apply_theme(app_as_before, DARK)
    within = window
    widgets = [window]
    for depth in range(1, 8):
        within = QPushButton(within, objectName=str(depth))
        widgets.append(within)
    widgets.append(QDialog(window, objectName="dialog"))
    window.show()
    for widget in widgets:
        widget.ensurePolished()
    changes = StyleChanges()
    for widget in widgets:
        widget.installEventFilter(changes)
    for theme in (LIGHT, DARK):
        changes.of.clear()
        apply_theme(app_as_before, theme)
        assert changes.of == Counter({widget.objectName(): 1 for widget in widgets})
        assert {widget.palette().color(QPalette.ColorRole.WindowText).name() for widget in widgets} == {theme.text}
