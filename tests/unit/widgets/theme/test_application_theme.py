"""A theme dresses the whole application, Qt's own file dialog too."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtGui import QColor, QImage, QPalette

from widgets.common.colours import DARK, LIGHT
from widgets.theme.application_theme import apply_theme
from widgets.theme.dialog_icons import dialog_icons, dock_icons


@pytest.fixture
def app_as_before(qapp):
    style, palette, font, sheet = qapp.style().objectName(), qapp.palette(), qapp.font(), qapp.styleSheet()
    yield qapp
    qapp.setStyleSheet(sheet)
    qapp.setStyle(style)
    qapp.setPalette(palette)
    qapp.setFont(font)


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_a_theme_dresses_the_whole_application(app_as_before, theme):
    apply_theme(app_as_before, theme)
    palette = app_as_before.palette()
    assert palette.color(QPalette.ColorRole.Window) == QColor(theme.panel)
    assert palette.color(QPalette.ColorRole.WindowText) == QColor(theme.text)
    assert app_as_before.font().pixelSize() == 13
    assert theme.line in app_as_before.styleSheet()


@pytest.mark.parametrize("theme", [DARK, LIGHT], ids=lambda theme: theme.name)
def test_icons_of_file_dialogs_and_docks_have_the_colour_of_text(qapp, theme):
    icons = dialog_icons(theme) | dock_icons(theme)
    assert "titlebar-close-icon" in icons
    for name, path in icons.items():
        fine = QImage(str(Path(path).with_stem(f"{Path(path).stem}@2x")))
        assert (fine.width(), QImage(path).width()) == (32, 16), name
        pixels = [fine.pixelColor(x, y) for x in range(32) for y in range(32)]
        full = {pixel.name() for pixel in pixels if pixel.alpha() > 250}
        assert full == {QColor(theme.text).name()}, name
