"""The guide in a window: pages, pictures, links, the way back."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QSize, QUrl
from PySide6.QtGui import QImage, QTextDocument
from PySide6.QtWidgets import QWidget

from tactile_maps.cli.commands.guide import find_page, page_names
from tactile_widgets.common.application_theme import apply_theme
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.common.guide_window import GuideWindow
from tactile_widgets.common.make import resize_on_screen


@pytest.fixture
def guide(qtbot):
    window = GuideWindow(find_page("index"))
    qtbot.addWidget(window)
    return window


def test_window_is_no_higher_than_its_screen(qtbot):
    window = QWidget()
    qtbot.addWidget(window)
    resize_on_screen(window, 400, 300)
    assert window.size() == QSize(400, 300)
    resize_on_screen(window, 400, 10_000)
    assert window.width() == 400
    assert window.height() < window.screen().availableSize().height()


@pytest.mark.long
def test_every_page_shows_its_pictures(guide):
    pictures = 0
    for name in page_names():
        guide.show_page(find_page(name))
        text = guide.toPlainText()
        assert text.startswith(find_page(name).read_text(encoding="utf8").splitlines()[0].removeprefix("# "))
        block = guide.document().begin()
        while block.isValid():
            for part in block:
                image = part.fragment().charFormat().toImageFormat()
                if image.isValid():
                    shown = guide.loadResource(QTextDocument.ResourceType.ImageResource.value, QUrl(image.name()))
                    assert isinstance(shown, QImage)
                    assert 0 < shown.width() < guide.width()
                    pictures += 1
            block = block.next()
    assert pictures >= 5


def test_link_opens_a_page_and_back_returns(guide):
    guide.setSource(guide.source().resolved(QUrl("maps.md")))
    assert guide.toPlainText().startswith("Maps")
    guide.backward()
    assert guide.toPlainText().startswith("The guide")


def link_colours(guide):
    """Return the colours of the links on the page."""
    found = set()
    block = guide.document().begin()
    while block.isValid():
        found |= {
            part.fragment().charFormat().foreground().color().name()
            for part in block
            if part.fragment().charFormat().isAnchor()
        }
        block = block.next()
    return found


def test_links_take_the_colour_of_another_theme(guide, qapp):
    for theme in (LIGHT, DARK):
        apply_theme(qapp, theme)
        assert link_colours(guide) == {theme.link}
