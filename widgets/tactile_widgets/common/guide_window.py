"""Window of the guide: Markdown pages with pictures and links."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, Qt, QUrl
from PySide6.QtGui import QImage, QKeySequence, QShortcut, QTextBlock, QTextCursor, QTextDocument, QTextFormat
from PySide6.QtWidgets import QTextBrowser, QWidget

from tactile_widgets.common.make import resize_on_screen


@dataclass(frozen=True)
class GuidePlace:
    """A section of the guide.

    Attributes:
        page: Name of the page, as in ``tactile-maps guide``.
        heading: Heading of the section; empty for the start of the page.
    """

    page: str
    heading: str = ""


_SIZE = (980, 860)
_MARGIN = 24
_SPACE = 10
_SMOOTH = Qt.TransformationMode.SmoothTransformation


class GuideWindow(QTextBrowser):
    """Shows a page and follows its links; web links open in the browser. Alt+Left goes back, Escape closes.

    Args:
        page: A Markdown file.
        parent: Qt parent; the window stays above it.
    """

    def __init__(self, page: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowFlag(Qt.WindowType.Window)
        self.setWindowTitle("Tactile Maps: the guide")
        resize_on_screen(self, *_SIZE)
        self.setOpenExternalLinks(True)
        self.document().setDocumentMargin(_MARGIN)
        QShortcut(QKeySequence(QKeySequence.StandardKey.Back), self, self.backward)
        QShortcut(QKeySequence("Escape"), self, self.close)
        self.show_page(page)

    def changeEvent(self, event: QEvent) -> None:
        """Read the page again in another theme: links keep the colour with which they were read."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and self.source().isValid():
            place = self.verticalScrollBar().value()
            self.reload()
            self.verticalScrollBar().setValue(place)

    def show_page(self, page: Path, heading: str = "") -> None:
        """Show a page from a heading, or from its start if there is no such heading."""
        self.setSource(QUrl.fromLocalFile(str(page)), QTextDocument.ResourceType.MarkdownResource)
        block = self.document().begin()
        while heading and block.isValid() and not (block.blockFormat().headingLevel() and block.text() == heading):
            block = block.next()
        if heading and block.isValid():
            place = self.document().documentLayout().blockBoundingRect(block).top()
            self.verticalScrollBar().setValue(round(place) - _SPACE)

    def loadResource(self, type: int, name: QUrl | str) -> Any:
        """Scale pictures down to the width of the window."""
        found = super().loadResource(type, name)
        if type != QTextDocument.ResourceType.ImageResource.value:
            return found
        picture = QImage(self.source().resolved(QUrl(name)).toLocalFile())
        room = _SIZE[0] - 3 * _MARGIN
        return picture.scaledToWidth(room, _SMOOTH) if picture.width() > room else picture

    def doSetSource(
        self, name: QUrl | str, type: QTextDocument.ResourceType = QTextDocument.ResourceType.UnknownResource
    ) -> None:
        """Add space between the paragraphs of each page, also of those reached by links or by going back."""
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
