"""Base class of panels, and their parts: collapsible heading, sliders, combo boxes and value labels.

A panel is a heading above a column that can be folded; groups are separated by space, not by frames. ``FlatComboBox``
is a combo box with text and a chevron, and a frame only under the pointer or with the keyboard focus.
"""

from __future__ import annotations

from PySide6.QtCore import QPoint, QPointF, QRectF, QSignalBlocker, QSize, Qt, QTimer, Signal
from PySide6.QtGui import (
    QContextMenuEvent,
    QFont,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QPolygonF,
    QShortcut,
)
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QGridLayout,
    QLabel,
    QMenu,
    QPushButton,
    QSizePolicy,
    QSlider,
    QToolButton,
    QWidget,
)

from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import DELETED_ON_CLOSE, add_entry, caption_label, column_layout, make, row_layout
from tactile_widgets.common.number_field import NumberField, guard_wheel

_HEADING_CHEVRON = 4.0
"""Half the width of the chevron [px]."""
_HELP_PX = 20
"""Size of the button that opens the guide [px]."""


class CollapsibleHeading(QAbstractButton):
    """Bold text and a chevron at the end of the line, which points up if open; checked means folded."""

    menu_requested = Signal(QPoint)
    """Position on the screen at which the context menu is requested."""

    def __init__(self, text: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setText(text)
        self.setCheckable(True)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)  # a click does not take the focus from a view
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.toggled.connect(self._on_toggled)
        self._on_toggled(False)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        self.menu_requested.emit(event.globalPos())

    def sizeHint(self) -> QSize:
        metrics = self.fontMetrics()
        return QSize(metrics.horizontalAdvance(self.text()) + 32, metrics.height() + 4)

    def minimumSizeHint(self) -> QSize:
        return self.sizeHint()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the text at the left and the chevron at the right, coloured under the pointer or with the focus."""
        painter = QPainter(self)
        palette = self.palette()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        font = QFont(self.font())
        font.setWeight(QFont.Weight.DemiBold)
        painter.setFont(font)
        painter.setPen(palette.color(QPalette.ColorRole.WindowText))
        painter.drawText(self.rect(), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, self.text())
        marked = self.underMouse() or self.hasFocus()
        role = QPalette.ColorRole.Link if marked else QPalette.ColorRole.PlaceholderText
        painter.setPen(QPen(palette.color(role), 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        middle = QRectF(self.rect()).center()
        tip = -_HEADING_CHEVRON / 2 if not self.isChecked() else _HEADING_CHEVRON / 2
        corners = [QPointF(x, tip if x == 0 else -tip) for x in (-_HEADING_CHEVRON, 0.0, _HEADING_CHEVRON)]
        painter.translate(self.width() - _HEADING_CHEVRON - 2, middle.y())
        painter.drawPolyline(QPolygonF(corners))

    def _on_toggled(self, folded: bool) -> None:
        self.setToolTip("Unfold" if folded else "Fold")
        self.setAccessibleName(f"{self.text()}, folded" if folded else self.text())


_SETTLE_MS = 300
"""Time after the last key or wheel event until a value counts as final [ms]."""


SLIM_SCROLL_BAR = """
    QScrollBar:vertical { width: 8px; margin: 0; background: transparent; border: 0; }
    QScrollBar::handle:vertical { background: palette(mid); border-radius: 4px; min-height: 32px; }
    QScrollBar::add-line:vertical, QScrollBar::sub-line:vertical { height: 0; }
    QScrollBar::add-page:vertical, QScrollBar::sub-page:vertical { background: transparent; }
"""
"""Style sheet of narrow scroll bars."""
_OWN_TIP = "own-tip"
"""Dynamic property of a button: its tool tip without the reason for which it is disabled."""
MIXED_VALUES = "—"
"""Text shown for several different values."""


class Panel(QWidget):
    """A heading and a column; a click on the heading folds the column.

    Args:
        heading: Text of the heading.
        name: Object name, used in settings and tests.

    Attributes:
        undocked: True if the panel is in its own window.
        help: Button that opens the guide; the contents of the panel follow it in the tab order.
    """

    folded_changed = Signal(bool)
    """The user folded (True) or unfolded the panel."""
    help_requested = Signal()
    """The user requests the guide."""
    undock_requested = Signal()
    """The user moves the panel to its own window, or back to the column."""
    simulates = False
    """True if the panel changes a simulation, so that it is disabled while a real skin is shown."""
    search_words = ""
    """Words by which the command palette finds the panel, in addition to its heading."""

    def __init__(self, heading: str, name: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName(name)
        self.setAccessibleName(heading)
        self._heading, self._body = CollapsibleHeading(heading, self), QWidget(self)
        self._heading.setObjectName(f"{name}-heading")
        self._heading.toggled.connect(self._body.setHidden)
        self._heading.clicked.connect(self.folded_changed)
        self._heading.menu_requested.connect(self._show_menu)
        # With its focus proxy, the panel is one unit for ``setTabOrder``; it receives no focus itself.
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self.setFocusProxy(self._heading)
        self.undocked = False
        self.column = column_layout(parent=self._body)
        self.help = self._help_button()
        self._reason: QLabel | None = None
        top = row_layout(self._heading, self.help, stretch=self._heading)
        column_layout(top, self._body, parent=self, margins=(12, 12, 12, 4))

    def set_heading(self, text: str) -> None:
        """Set the text of the heading, such as with a count."""
        self._heading.setText(text)
        self._heading.update()

    def _help_button(self) -> QToolButton:
        return make(
            QToolButton,
            self,
            objectName=f"{self.objectName()}-help",
            text="?",
            autoRaise=True,
            fixedSize=QSize(_HELP_PX, _HELP_PX),
            focusPolicy=Qt.FocusPolicy.TabFocus,
            toolTip="What is this? Opens the guide",
            accessibleName=f"What is {self.accessibleName()}?",
            clicked=self.help_requested,
        )

    def _show_menu(self, place: QPoint) -> None:
        menu = make(QMenu, self, attribute=DELETED_ON_CLOSE)
        add_entry(menu, "Unfold" if self.folded else "Fold", self._heading.click)
        words = "Back to the column" if self.undocked else "Undock"
        add_entry(menu, words, self.undock_requested.emit, objectName="undock")
        add_entry(menu, "What is this?", self.help_requested.emit)
        menu.popup(place)

    @property
    def folded(self) -> bool:
        """True if only the heading is shown."""
        return self._heading.isChecked()

    def set_folded(self, folded: bool) -> None:
        """Fold or unfold it without emitting."""
        self._heading.setChecked(folded)

    # Events for all panels; each overrides those that it needs.

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another scene."""

    def show_frame(self, frame: Frame) -> None:
        """Receive a frame, many times a second; panels store it and redraw a few times a second."""

    def set_editable(self, *, editable: bool) -> None:
        """Enable or disable changes of the simulation; disabled during a replay."""

    def show_reason(self, text: str) -> None:
        """Show below the heading, and in tool tips, why nothing can be changed; an empty text removes it."""
        for button in self.findChildren(QPushButton):
            own = button.property(_OWN_TIP) or button.toolTip()
            button.setProperty(_OWN_TIP, own if text else None)
            button.setToolTip("\n".join(filter(None, (own, text))))
        if self._reason is None:
            if not text:
                return
            self._reason = self.caption(name=f"{self.objectName()}-reason")
            self.column.insertWidget(0, self._reason)
        self._reason.setText(text)
        self._reason.setHidden(not text)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme beyond the palette."""

    def caption(self, text: str = "", name: str = "", *, kind: type[QLabel] = QLabel) -> QLabel:
        """Add a line of small dimmed text at the end of the column."""
        label = caption_label(self, name, text, kind=kind)
        label.setMinimumWidth(1)  # a long path in it is cut, and does not widen the panel
        self.column.addWidget(label)
        return label

    def grid(self) -> QGridLayout:
        """Add a grid for rows of values at the end of the column."""
        grid = QGridLayout()
        grid.setHorizontalSpacing(12)
        grid.setVerticalSpacing(4)
        self.column.addLayout(grid)
        return grid


class _ClickableLabel(QLabel):
    """A label that reports double-clicks."""

    double_clicked = Signal()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        event.accept()
        self.double_clicked.emit()


class LabelledSlider(QWidget):
    """A label, a slider, and a number field with unit."""

    value_changed = Signal(float)
    rested = Signal(float)
    """The user let go of a value other than before, for what is too slow to follow it."""
    default_requested = Signal()
    """Its name was double-clicked, or Delete was pressed on the slider: the receiver restores the default value."""

    def __init__(
        self, text: str, unit: str, low: float, high: float, step: float, tip: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._low = low
        self._high = high
        self._step = step
        self._number = low
        self._rest: float | None = low  # last value of ``rested``; None for mixed values
        self._name, self._value = _ClickableLabel(text, self), NumberField(text, unit, low, high, step, tip, self)
        self._value.valueChanged.connect(self._on_typed)
        self._slider = make(
            QSlider,
            Qt.Orientation.Horizontal,
            self,
            maximum=round((high - low) / step),
            accessibleName=text,
            toolTip=tip,
            valueChanged=self._on_slider_moved,
            sliderReleased=self._on_rested,
        )
        self._name.double_clicked.connect(self.default_requested)
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self._slider)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        delete.activated.connect(self.default_requested)
        self._quiet = make(QTimer, self, singleShot=True, interval=_SETTLE_MS, timeout=self._on_rested)
        top = row_layout(self._name, self._value, spacing=2, stretch=self._name)
        column_layout(top, self._slider, parent=self, spacing=2)
        self._show()

    @property
    def value(self) -> float:
        """Current value, in the unit shown."""
        return self._number

    def set_value(self, value: float) -> None:
        """Show a value without emitting; outside the range the handle is at the end, and the number is not clipped."""
        self._number = self._rest = value
        self._quiet.stop()
        near = min(max(value, self._low), self._high)
        with QSignalBlocker(self._slider):
            self._slider.setValue(round((near - self._low) / self._step))
        self._show()

    @property
    def held(self) -> bool:
        """True while the user is moving the slider, so that it must not be set by the program."""
        return self._slider.isSliderDown() or self._quiet.isActive()

    def set_mixed(self) -> None:
        """Show that there are several values; the handle is in the middle."""
        self.set_value(0.5 * (self._low + self._high))
        self._rest = None
        self._value.show_words(MIXED_VALUES)
        self._slider.setAccessibleDescription("several values")

    def set_default_tip(self, words: str) -> None:
        """Set the tool tip of the label, given the text of the default value."""
        self._name.setToolTip(f"Double-click for {words}, or press Delete on the slider")

    def set_tip(self, tip: str) -> None:
        """Set another tool tip, such as why the slider is disabled."""
        self._slider.setToolTip(tip)
        self.setToolTip(tip)

    def _on_slider_moved(self, position: int) -> None:
        self._number = self._low + self._step * position
        self._show()
        self.value_changed.emit(self.value)
        if not self._slider.isSliderDown():
            self._quiet.start()

    def _on_typed(self, number: float) -> None:
        self.set_value(number)
        self._rest = None
        self.value_changed.emit(number)
        self._on_rested()

    def _on_rested(self) -> None:
        self._quiet.stop()
        if self._number != self._rest:
            self._rest = self._number
            self.rested.emit(self._number)

    def _show(self) -> None:
        self._value.show_number(self._number)
        self._slider.setAccessibleDescription(self._value.text())


_PAD = 6.0
_CHEVRON = 3.5
_ROUND = 4.0
"""Padding of the text, half the width of the chevron, radius of the corners of the frame [px]."""


class FlatComboBox(QComboBox):
    """Combo box that shows its own text instead of the current entry; the wheel changes it only with the focus."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._words = ""
        self._quiet = False
        guard_wheel(self)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)
        # Its own text is elided; the list is as wide as it has to be.
        self.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon)
        self.setMinimumContentsLength(12)

    def showPopup(self) -> None:
        self.view().setMinimumWidth(self.view().sizeHintForColumn(0) + round(2 * _PAD) + 8)
        super().showPopup()

    @property
    def words(self) -> str:
        """Text shown."""
        return self._words

    def say(self, words: str, *, quiet: bool = False) -> None:
        """Show a text; ``quiet`` draws it grey, for settings that are off."""
        self._words = words
        self._quiet = quiet
        self.setAccessibleDescription(words)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw text and chevron, and a frame under the pointer or with the focus."""
        painter = QPainter(self)
        palette = self.palette()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5)
        used = self.isEnabled() and (self.underMouse() or self.hasFocus())
        if used:
            painter.setPen(palette.color(QPalette.ColorRole.Link if self.hasFocus() else QPalette.ColorRole.Mid))
            painter.setBrush(palette.color(QPalette.ColorRole.Button))
            painter.drawRoundedRect(box, _ROUND, _ROUND)
            painter.setBrush(Qt.BrushStyle.NoBrush)
        quiet = palette.color(QPalette.ColorRole.PlaceholderText)
        painter.setPen(quiet if self._quiet and self.isEnabled() else palette.color(QPalette.ColorRole.ButtonText))
        words = box.adjusted(_PAD, 0, -4 * _CHEVRON, 0)
        text = self.fontMetrics().elidedText(self._words, Qt.TextElideMode.ElideRight, int(words.width()))
        painter.drawText(words, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text)
        if self.isEnabled():
            painter.setPen(QPen(quiet, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
            painter.translate(box.right() - _PAD - _CHEVRON, box.center().y() - _CHEVRON / 4)
            corners = [QPointF(x, _CHEVRON / 2 if x == 0 else -_CHEVRON / 2) for x in (-_CHEVRON, 0.0, _CHEVRON)]
            painter.drawPolyline(QPolygonF(corners))
