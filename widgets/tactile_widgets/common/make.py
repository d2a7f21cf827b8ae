"""Construction of Qt objects with settings as keyword arguments, and the parts that panels and dialogs share.

PySide's own constructors take properties and slots as keyword arguments too, but their type stubs omit inherited ones,
and Python subclasses do not pass them on. ``make`` works with any class.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from PySide6.QtCore import QEvent, QObject, QSize, Qt, SignalInstance
from PySide6.QtGui import QAction, QFont, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QMenu,
    QProgressBar,
    QPushButton,
    QSizePolicy,
    QVBoxLayout,
    QWidget,
)

_FRAME = 60
"""Room for the frame and the title of a window [px]."""
T = TypeVar("T", bound=QObject)
Part = QWidget | QLayout | None
Margins = tuple[int, int, int, int]
NO_MARGINS = 0, 0, 0, 0
DELETED_ON_CLOSE = Qt.WidgetAttribute.WA_DeleteOnClose
STYLE_SPACING = -1


def resize_on_screen(window: QWidget, width: int, height: int) -> None:
    """Resize a window, but no higher than its screen: buttons at the lower edge would be out of reach."""
    window.resize(width, min(height, window.screen().availableSize().height() - _FRAME))


def make(kind: Callable[..., T], *args: object, **settings: Any) -> T:
    """Construct a Qt object and apply settings to it, in their order.

    Args:
        kind: Class of the object.
        args: Positional arguments of its constructor.
        settings: Values by property name (``toolTip="…"`` calls ``setToolTip``) and slots by signal name; ``role`` is
            the dynamic property that the style sheet reads.
    """
    made = kind(*args)
    for name, value in settings.items():
        if name == "role":
            made.setProperty(name, value)
        elif isinstance(signal := getattr(made, name, None), SignalInstance):
            signal.connect(value)
        else:
            getattr(made, f"set{name[0].upper()}{name[1:]}")(value)
    return made


def push_button(
    parent: QWidget, name: str, text: str, tip: str, clicked: object = None, **settings: Any
) -> QPushButton:
    """Construct a button that calls ``clicked``; see ``make`` for ``settings``."""
    if clicked is not None:
        settings["clicked"] = clicked
    return make(QPushButton, text, parent, objectName=name, toolTip=tip, **settings)


class SteadyLabel(QLabel):
    """Label that wraps and keeps the height of its highest text, by width, so that nothing around it moves.

    A shorter text in the last row of a page that is scrolled to its end would move the whole page.
    """

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self._highest: dict[int, int] = {}

    def heightForWidth(self, width: int) -> int:
        self._highest[width] = max(self._highest.get(width, 0), super().heightForWidth(width))
        return self._highest[width]


def caption_label(parent: QWidget, name: str = "", text: str = "", *, kind: type[QLabel] = QLabel) -> QLabel:
    """Construct a label for small, quiet text that wraps."""
    return make(kind, text, parent, objectName=name, role="caption", wordWrap=True)


class RichLabel(QLabel):
    """Label of rich text whose links and ``palette(...)`` colours follow the theme.

    Qt reads these colours from the palette of the application only when the text is set.
    """

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            text = self.text()
            self.clear()  # the same text would not be read again
            self.setText(text)


def value_label(text: str, parent: QWidget, *, right: bool = False, **settings: Any) -> QLabel:
    """Construct a label for a changing value."""
    side = Qt.AlignmentFlag.AlignRight if right else Qt.AlignmentFlag.AlignLeft
    return make(QLabel, text, parent, alignment=side | Qt.AlignmentFlag.AlignVCenter, **settings)


def progress_bar(parent: QWidget, accessible_name: str = "Progress") -> QProgressBar:
    """Construct a thin bar of 1000 steps without text."""
    return make(
        QProgressBar, parent, minimum=0, maximum=1000, textVisible=False, fixedHeight=6, accessibleName=accessible_name
    )


def small_font(font: QFont, pixels: int = 11) -> QFont:
    """Return the font in the size of captions."""
    small = QFont(font)
    small.setPixelSize(pixels)
    return small


def show_text(label: QLabel, text: str) -> None:
    """Set the text of a label, and hide the label while the text is empty, so that it leaves no gap."""
    label.setText(text)
    label.setVisible(bool(text))


def add_items(box: QComboBox, items: Iterable[tuple[str, object, str]]) -> None:
    """Add (text, data, tool tip) entries to a combo box."""
    for text, data, tip in items:
        box.addItem(text, data)
        if tip:
            box.setItemData(box.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)


def select_data(box: QComboBox, data: object) -> None:
    """Select the entry with this data."""
    box.setCurrentIndex(box.findData(data))


def add_entry(menu: QMenu, text: str, run: Callable[[], object], **settings: Any) -> None:
    """Add an entry with this text, in which ``&`` is no mnemonic, to a menu; see ``make`` for ``settings``."""
    menu.addAction(make(QAction, text.replace("&", "&&"), menu, triggered=lambda: run(), **settings))


def accept_buttons(dialog: QDialog, text: str, accepted: Callable[[], None]) -> tuple[QDialogButtonBox, QPushButton]:
    """Construct the buttons of a dialog, *Cancel* and one with this text; return them and the latter."""
    cancel = QDialogButtonBox.StandardButton.Cancel
    box = make(QDialogButtonBox, cancel, dialog, accepted=accepted, rejected=dialog.reject)
    return box, box.addButton(text, QDialogButtonBox.ButtonRole.AcceptRole)


def column_layout(
    *parts: Part,
    parent: QWidget | None = None,
    spacing: int = 8,
    stretch: QWidget | None = None,
    margins: Margins | None = NO_MARGINS,
) -> QVBoxLayout:
    """Lay out parts from top to bottom; see ``row_layout``."""
    layout = QVBoxLayout() if parent is None else QVBoxLayout(parent)
    return _filled(layout, parts, spacing, stretch, margins)


def row_layout(
    *parts: Part,
    parent: QWidget | None = None,
    spacing: int = 8,
    stretch: QWidget | None = None,
    margins: Margins | None = NO_MARGINS,
) -> QHBoxLayout:
    """Lay out parts from left to right.

    Args:
        parts: Widgets and layouts; None for a gap that takes the remaining space.
        parent: Widget that is laid out; None for a layout within another.
        spacing: Distance between parts [px]; ``STYLE_SPACING`` for that of the style.
        stretch: The widget that takes the remaining space.
        margins: Left, upper, right and lower margin [px]; None for those of the style.
    """
    layout = QHBoxLayout() if parent is None else QHBoxLayout(parent)
    return _filled(layout, parts, spacing, stretch, margins)


L = TypeVar("L", bound=QBoxLayout)


def _filled(layout: L, parts: Iterable[Part], spacing: int, stretch: QWidget | None, margins: Margins | None) -> L:
    if margins is not None:
        layout.setContentsMargins(*margins)
    layout.setSpacing(spacing)
    for part in parts:
        if part is None:
            layout.addStretch()
        elif isinstance(part, QLayout):
            layout.addLayout(part)
        else:
            layout.addWidget(part, int(part is stretch))
    return layout


def button_grid(buttons: Iterable[QWidget], parent: QWidget | None = None) -> QGridLayout:
    """Lay out buttons in rows of two."""
    grid = make(QGridLayout, *([] if parent is None else [parent]), spacing=4)
    grid.setContentsMargins(0, 0, 0, 0)
    for number, button in enumerate(buttons):
        grid.addWidget(button, *divmod(number, 2))
    return grid


def add_fact(grid: QGridLayout, row: int, text: str, tip: str, value: QWidget) -> QLabel:
    """Add a row of a name and a value to a grid, and return the label of the name."""
    parent = value.parentWidget()
    assert parent is not None
    name = value_label(text, parent, toolTip=tip)
    grid.addWidget(name, row, 0)
    grid.addWidget(value, row, 1)
    return name


_LEAST_PX = 24


class ElidedLabel(QLabel):
    """Label that elides its text down to a few letters and shows the whole text in the tool tip.

    Args:
        name: Object name.
        parent: Qt parent.
        elided: Part of the text that is left out first.
    """

    def __init__(
        self,
        name: str,
        parent: QWidget | None = None,
        *,
        elided: Qt.TextElideMode = Qt.TextElideMode.ElideRight,
    ) -> None:
        super().__init__(parent)
        self._elided = elided
        self.setObjectName(name)
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)

    @property
    def shown(self) -> str:
        """Text as drawn."""
        return self.fontMetrics().elidedText(self.text(), self._elided, self.contentsRect().width())

    def minimumSizeHint(self) -> QSize:
        return QSize(min(_LEAST_PX, super().sizeHint().width()), super().sizeHint().height())

    def setText(self, text: str) -> None:
        super().setText(text)
        self._update_tool_tip()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._update_tool_tip()

    def _update_tool_tip(self) -> None:
        self.setToolTip("" if self.shown == self.text() else self.text())

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        painter.drawText(self.contentsRect(), int(self.alignment() | Qt.AlignmentFlag.AlignVCenter), self.shown)
        painter.end()
