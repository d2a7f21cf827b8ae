"""Plots in a row or a column that can be dragged to another place, enlarged, or moved to separate windows.

``PlotCell`` contains one plot and handles gestures; ``PlotBoard`` lays out the cells and emits their requests.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, QRect, Qt, Signal
from PySide6.QtGui import QCloseEvent, QContextMenuEvent, QKeyEvent, QMouseEvent, QResizeEvent
from PySide6.QtWidgets import QApplication, QBoxLayout, QFrame, QScrollArea, QWidget

from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import column_layout
from tactile_widgets.plots.choice.plot_choice import PlotKey, Rectangle

NARROWEST = 150
LOWEST_CELL = 110
"""Minimum width of a plot in a row and minimum height in a column [px]; if they do not fit, the board scrolls."""
_WINDOW_SIZE = (520, 320)
_STEP = 28
"""Offset from one new window to the next [px]."""
_SLIM = "QScrollBar:horizontal { height: 6px; } QScrollBar:vertical { width: 6px; }"


class PlotCell(QWidget):
    """Widget with one plot that handles its gestures: drag, click, double-click and context menu."""

    dragged = Signal(QPoint)
    """The plot is dragged over this screen position."""
    dropped = Signal(QPoint)
    """The plot was dropped at this screen position."""
    clicked = Signal(QPointF)
    """The plot was clicked at this position of its content."""
    enlarge_requested = Signal()
    """The plot was double-clicked."""
    menu_requested = Signal(QPoint)
    """The context menu is requested at this screen position."""

    def __init__(self, key: PlotKey, content: QWidget, parent: QWidget) -> None:
        super().__init__(parent)
        self.key = key
        self.content = content
        self.setObjectName(f"plot-{key.text}")
        self.setAccessibleName(key.title)
        self.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        column_layout(content, parent=self)
        self._pressed: QPointF | None = None
        self._dragging = False
        for widget in (content, *content.findChildren(QWidget)):
            widget.installEventFilter(self)
            widget.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # Tab stops at the cell, which has the keys and the name

    def hasHeightForWidth(self) -> bool:
        """Whether the height depends on the width; no, or a legend of two lines would make the board scroll."""
        return False

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle mouse events of all child widgets."""
        if isinstance(event, QContextMenuEvent):
            self.menu_requested.emit(event.globalPos())
            return True
        return isinstance(event, QMouseEvent) and self._mouse(event)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Handle the menu key; mouse events arrive at the child widgets."""
        self.menu_requested.emit(event.globalPos())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Enlarge the plot with Return."""
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.enlarge_requested.emit()
        else:
            super().keyPressEvent(event)

    def _mouse(self, event: QMouseEvent) -> bool:
        left = event.button() == Qt.MouseButton.LeftButton
        place = event.globalPosition()
        match event.type():
            case QEvent.Type.MouseButtonPress if left:
                self._pressed = place
                self._dragging = False
            case QEvent.Type.MouseMove if self._pressed is not None:
                self._move(place)
            case QEvent.Type.MouseButtonRelease if left and self._pressed is not None:
                self._release(place)
            case QEvent.Type.MouseButtonDblClick if left:
                self._pressed = None
                self.enlarge_requested.emit()
            case _:
                return False
        return True

    def _move(self, place: QPointF) -> None:
        assert self._pressed is not None
        far = (place - self._pressed).manhattanLength() >= QApplication.startDragDistance()
        if far and not self._dragging:
            self._dragging = True
            self.setCursor(Qt.CursorShape.ClosedHandCursor)
        if self._dragging:
            self.dragged.emit(place.toPoint())

    def _release(self, place: QPointF) -> None:
        dragging = self._dragging
        self._pressed = None
        self._dragging = False
        self.unsetCursor()
        if dragging:
            self.dropped.emit(place.toPoint())
        else:
            self.clicked.emit(self.content.mapFromGlobal(place))


class PlotWindow(QWidget):
    """Separate window with one plot."""

    closed = Signal(PlotKey)
    """The user closed the window of this plot."""

    def __init__(self, cell: PlotCell, parent: QWidget) -> None:
        super().__init__(parent, Qt.WindowType.Window)
        self.cell = cell
        self.setObjectName(f"window-{cell.key.text}")
        self.setWindowTitle(cell.key.title)
        self.setAutoFillBackground(True)
        column_layout(cell, parent=self, margins=(12, 8, 12, 8))
        cell.show()

    @property
    def rectangle(self) -> Rectangle:
        """Geometry on the screen."""
        place = self.geometry()
        return place.x(), place.y(), place.width(), place.height()

    def closeEvent(self, event: QCloseEvent) -> None:
        super().closeEvent(event)
        self.closed.emit(self.cell.key)


class PlotBoard(QScrollArea):
    """Scrollable area that lays out the cells. Mutable: ``add``, ``arrange``, ``enlarge``, ``open_window``."""

    move_requested = Signal(PlotKey, PlotKey)
    """Move the first plot to the left of the second, or to the end if that is None."""
    window_closed = Signal(PlotKey)
    """The window of this plot was closed."""
    enlarged_changed = Signal(bool)
    """True: one plot fills the board. False: all are shown again."""

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setStyleSheet(_SLIM)
        self._content = QWidget(self)
        self.setWidget(self._content)
        for widget in (self.viewport(), self._content):
            widget.setAutoFillBackground(False)
        self._row = QBoxLayout(QBoxLayout.Direction.LeftToRight, self._content)
        self._row.setContentsMargins(0, 0, 0, 0)
        self._row.setSpacing(16)
        self._cells: dict[PlotKey, PlotCell] = {}
        self._windows: dict[PlotKey, PlotWindow] = {}
        self._shown: tuple[PlotKey, ...] = ()
        self._enlarged: PlotKey | None = None
        self._mark = QWidget(self._content)
        self._mark.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._mark.hide()
        self.set_theme(theme)

    @property
    def enlarged(self) -> PlotKey | None:
        """Plot that fills the board; None if all are shown."""
        return self._enlarged

    @property
    def windows(self) -> dict[PlotKey, Rectangle]:
        """Plots in separate windows, with the window geometry."""
        return {key: window.rectangle for key, window in self._windows.items()}

    def cell(self, key: PlotKey) -> PlotCell | None:
        """Return the cell of a plot."""
        return self._cells.get(key)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._mark.setStyleSheet(f"background: {theme.accent}")

    def add(self, key: PlotKey, content: QWidget, stretch: int) -> PlotCell:
        """Add a plot, hidden until ``arrange`` shows it."""
        cell = self._cells[key] = PlotCell(key, content, self._content)
        cell.hide()
        self._row.addWidget(cell, stretch)
        cell.dragged.connect(partial(self._show_mark, key))
        cell.dropped.connect(partial(self._drop, key))
        cell.enlarge_requested.connect(partial(self.toggle, key))
        return cell

    def remove(self, key: PlotKey) -> None:
        """Remove a plot."""
        self.close_window(key)
        if self._enlarged == key:
            self.enlarge(None)
        cell = self._cells.pop(key)
        self._row.removeWidget(cell)
        cell.hide()
        cell.deleteLater()

    def arrange(self, shown: Sequence[PlotKey]) -> None:
        """Show these plots in this order; plots with separate windows stay there."""
        self._shown = tuple(shown)
        if self._enlarged not in shown:
            self.enlarge(None)
        here = self._here
        for key in here:
            cell = self._cells[key]
            if self._row.indexOf(cell) != here.index(key):
                stretch = self._row.stretch(self._row.indexOf(cell))
                self._row.removeWidget(cell)
                self._row.insertWidget(here.index(key), cell, stretch)
        for key, cell in self._cells.items():
            if key not in self._windows:
                cell.setVisible(key in here and self._enlarged in (None, key))
        self._make_room()

    @property
    def _here(self) -> list[PlotKey]:
        """Shown plots without a separate window, in order."""
        return [key for key in self._shown if key not in self._windows]

    @property
    def horizontal(self) -> bool:
        """Whether the plots are side by side."""
        return self._row.direction() == QBoxLayout.Direction.LeftToRight

    def set_horizontal(self, *, horizontal: bool) -> None:
        """Arrange the plots side by side, or one below the other."""
        directions = QBoxLayout.Direction
        self._row.setDirection(directions.LeftToRight if horizontal else directions.TopToBottom)
        self._make_room()

    def _make_room(self) -> None:
        count = 1 if self._enlarged is not None else max(len(self._here), 1)
        wide, high = (NARROWEST + self._row.spacing(), 0) if self.horizontal else (0, LOWEST_CELL + self._row.spacing())
        self._content.setMinimumSize(count * wide - self._row.spacing() if wide else 0, count * high)

    def enlarge(self, key: PlotKey | None) -> None:
        """Let one plot fill the board; None shows all of them."""
        if key == self._enlarged or key in self._windows:
            return
        self._enlarged = key
        self.arrange(self._shown)
        self.enlarged_changed.emit(key is not None)

    def toggle(self, key: PlotKey) -> None:
        """Enlarge a plot, or show all plots again if it is enlarged."""
        self.enlarge(None if self._enlarged == key else key)

    # Windows.

    def open_window(self, key: PlotKey, where: Rectangle | None) -> None:
        """Move a plot to a separate window; without geometry, the window is offset from the last one."""
        if key in self._windows:
            return
        if self._enlarged == key:
            self.enlarge(None)
        cell = self._cells[key]
        self._row.removeWidget(cell)
        window = self._windows[key] = PlotWindow(cell, self)
        window.closed.connect(self._on_window_closed)
        if where is None:
            corner = self.mapToGlobal(QPoint(0, 0)) + QPoint(_STEP, _STEP) * len(self._windows)
            where = corner.x(), corner.y() - _WINDOW_SIZE[1] - 2 * _STEP, *_WINDOW_SIZE
        window.setGeometry(_on_screen(QRect(*where), self))
        window.show()
        self.arrange(self._shown)

    def close_window(self, key: PlotKey) -> None:
        """Move a plot from its window back to the board."""
        window = self._windows.pop(key, None)
        if window is not None:
            window.closed.disconnect(self._on_window_closed)
            self._row.addWidget(window.cell, 3)
            window.close()
            window.deleteLater()
            self.arrange(self._shown)

    def _on_window_closed(self, key: PlotKey) -> None:
        self.close_window(key)
        self.window_closed.emit(key)

    # Dragging.

    def _place_at(self, key: PlotKey, place: QPoint) -> PlotKey | None:
        """Return the plot that ``key`` would be placed left of, or above; None for the last place."""
        here = self._content.mapFromGlobal(place)
        for other in (one for one in self._here if one != key):
            middle = self._cells[other].geometry().center()
            if (here.x() < middle.x()) if self.horizontal else (here.y() < middle.y()):
                return other
        return None

    def _show_mark(self, key: PlotKey, place: QPoint) -> None:
        if key in self._windows or self._enlarged is not None:
            return
        before = self._place_at(key, place)
        gap = self._row.spacing() // 2
        neighbour = self._cells[before].geometry() if before is not None else self._cells[self._here[-1]].geometry()
        if self.horizontal:
            x = neighbour.left() - gap if before is not None else neighbour.right() + gap
            self._mark.setGeometry(x - 1, 0, 3, self._content.height())
        else:
            y = neighbour.top() - gap if before is not None else neighbour.bottom() + gap
            self._mark.setGeometry(0, y - 1, self._content.width(), 3)
        self._mark.raise_()
        self._mark.show()

    def _drop(self, key: PlotKey, place: QPoint) -> None:
        self._mark.hide()
        if key not in self._windows and self._enlarged is None:
            self.move_requested.emit(key, self._place_at(key, place))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._mark.hide()


def _on_screen(geometry: QRect, near: QWidget) -> QRect:
    """Return ``geometry`` if part of it is on a screen, else a rectangle of its size on the screen of ``near``."""
    if any(screen.availableGeometry().intersects(geometry) for screen in QApplication.screens()):
        return geometry
    screen = near.screen().availableGeometry()
    return QRect(screen.topLeft() + QPoint(_STEP, _STEP), geometry.size().boundedTo(screen.size()))
