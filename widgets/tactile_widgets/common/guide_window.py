"""The guide in a window: its Markdown pages with their pictures, links between them, and the way back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QImage, QKeySequence, QShortcut, QTextBlock, QTextCursor, QTextDocument, QTextFormat
from PySide6.QtWidgets import QTextBrowser, QWidget


@dataclass(frozen=True)
class GuidePlace:
    """Where in the guide something is told.

    Attributes:
        page: Its name, as ``tactile-maps guide`` takes it.
        heading: Of the section; empty for the page's beginning.
    """

    page: str
    heading: str = ""


_SIZE = (980, 860)
_MARGIN = 24
_SPACE = 10
_SMOOTH = Qt.TransformationMode.SmoothTransformation


class GuideWindow(QTextBrowser):
    """Shows a page and follows its links; those to the web open in the browser. Alt+Left goes back, Escape closes.

    Args:
        page: A Markdown file.
        parent: Qt parent; the window stays above it.
    """

    def __init__(self, page: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowFlag(Qt.WindowType.Window)
        self.setWindowTitle("Tactile Maps: the guide")
        self.resize(*_SIZE)
        self.setOpenExternalLinks(True)
        self.document().setDocumentMargin(_MARGIN)
        QShortcut(QKeySequence(QKeySequence.StandardKey.Back), self, self.backward)
        QShortcut(QKeySequence("Escape"), self, self.close)
        self.show_page(page)

    def show_page(self, page: Path, heading: str = "") -> None:
        """Turn to a page, and to the section of that heading; to its beginning where there is none."""
        self.setSource(QUrl.fromLocalFile(str(page)), QTextDocument.ResourceType.MarkdownResource)
        block = self.document().begin()
        while heading and block.isValid() and not (block.blockFormat().headingLevel() and block.text() == heading):
            block = block.next()
        if heading and block.isValid():
            place = self.document().documentLayout().blockBoundingRect(block).top()
            self.verticalScrollBar().setValue(round(place) - _SPACE)

    def loadResource(self, type: int, name: QUrl | str) -> Any:
        """Qt's own way to a page or picture; pictures are made no wider than the window."""
        found = super().loadResource(type, name)
        if type != QTextDocument.ResourceType.ImageResource.value:
            return found
        picture = QImage(self.source().resolved(QUrl(name)).toLocalFile())
        room = _SIZE[0] - 3 * _MARGIN
        return picture.scaledToWidth(room, _SMOOTH) if picture.width() > room else picture

    def doSetSource(
        self, name: QUrl | str, type: QTextDocument.ResourceType = QTextDocument.ResourceType.UnknownResource
    ) -> None:
        """Qt's own way to any page, by links and back too; here also the space between its paragraphs."""
        super().doSetSource(name, type)
        block = self.document().begin()
        while block.isValid():
            cursor = QTextCursor(block)
            if cursor.currentTable() is None and not (_is_code(block) and _is_code(block.next())):
                spaced = block.blockFormat()
                spaced.setBottomMargin(_SPACE)
                cursor.setBlockFormat(spaced)
            block = block.next()


def _is_code(block: QTextBlock) -> bool:
    return block.isValid() and block.blockFormat().hasProperty(QTextFormat.Property.BlockCodeFence)
