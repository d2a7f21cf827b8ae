"""Panels in windows of their own, and layouts of the window that are kept by name."""

from __future__ import annotations

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu, QScrollArea

from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel
from tactile_widgets.common.settings import Settings, WindowLayout
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.panels.panel_column import COLUMN_WIDTH, PanelColumn
from tactile_widgets.plots.choice.plot_choice import PlotChoice
from tactile_widgets.window.more_views import MoreViews

_SCROLL_BAR_PX = 16
_TALLEST_PX = 640


class _PanelDock(QDockWidget):
    """Holds one panel; closed, it gives the panel back."""

    def __init__(self, panel: Panel, docks: PanelDocks, window: QMainWindow) -> None:
        super().__init__(panel.accessibleName(), window)
        self.panel = panel
        self._docks = docks
        self.setObjectName(f"dock-{panel.objectName()}")
        area = QScrollArea(self)
        area.setWidgetResizable(True)
        area.setMinimumWidth(COLUMN_WIDTH)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.verticalScrollBar().setStyleSheet(SLIM_SCROLL_BAR)
        area.setWidget(panel)
        self.setWidget(area)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Qt: its panel goes back into the column."""
        super().closeEvent(event)
        self._docks.put_back(self)


class PanelDocks(QObject):
    """Undocks panels, puts them back, and keeps layouts: which panels are undocked or folded, and where all is.

    Args:
        window: Whose docks.
        column: Whose panels.
        views: Those that were added, which belong to a layout too.
        context: For settings, questions and messages.
    """

    arranged = Signal()
    """Another layout is in force; it may hide or show what lies beside the views."""

    def __init__(self, window: QMainWindow, column: PanelColumn, views: MoreViews, context: AppContext) -> None:
        super().__init__(window)
        self._window = window
        self._column = column
        self._views = views
        self._context = context
        self._docks: list[_PanelDock] = []
        column.undock_requested.connect(self.toggle)
        for name, handler in (("save_layout", self._ask_name), ("delete_layout", self._ask_which)):
            context.actions.bind(name, handler)

    @property
    def _settings(self) -> Settings:
        return self._context.settings

    def toggle(self, panel: Panel) -> None:
        """Give ``panel`` a window of its own beside the column, or put it back."""
        dock = next((dock for dock in self._docks if dock.panel is panel), None)
        if dock is not None:
            dock.close()
            return
        dock = self._undock(panel)
        dock.setFloating(True)
        corner = self._column.mapToGlobal(self._column.rect().topLeft())
        height = min(panel.sizeHint().height() + 2 * _SCROLL_BAR_PX, _TALLEST_PX)
        dock.resize(COLUMN_WIDTH + _SCROLL_BAR_PX, height)
        dock.move(corner.x() - dock.width() - _SCROLL_BAR_PX, corner.y() + _SCROLL_BAR_PX)
        dock.show()

    def _undock(self, panel: Panel) -> _PanelDock:
        panel.undocked = True
        dock = _PanelDock(panel, self, self._window)
        self._docks.append(dock)
        self._window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)
        panel.show()
        return dock

    def put_back(self, dock: _PanelDock) -> None:
        """The dock was closed."""
        if dock in self._docks:
            self._docks.remove(dock)
            area = dock.widget()
            assert isinstance(area, QScrollArea)
            area.takeWidget()
            self._column.put_back(dock.panel)
            self._window.removeDockWidget(dock)
            dock.deleteLater()

    # Layouts.

    @property
    def layout(self) -> WindowLayout:
        """As the window is arranged now."""
        undocked = tuple(dock.panel.objectName() for dock in self._docks)
        plots = self._context.plots.choice.to_text()
        return WindowLayout(undocked, self._column.folded, self._window.saveState(), plots, self._views.added)

    def arrange(self, layout: WindowLayout) -> None:
        """Arrange the window so; panels it names that are not there any more are left out."""
        self.gather()
        for panel in self._column:
            if panel.objectName() in layout.undocked:
                self._undock(panel)
        self._column.set_folded(layout.folded)
        self._views.add(layout.views)  # before the docks' places are: the second view has one
        self._window.restoreState(layout.state)
        self._context.plots.choose(PlotChoice.from_text(layout.plots))
        self.arranged.emit()

    def reset(self) -> None:
        """All panels in the column, and no view that was added."""
        self.gather()
        self._views.add(())

    def gather(self) -> None:
        """Put all panels back into the column."""
        for dock in tuple(self._docks):
            dock.close()

    def list_layouts(self, menu: QMenu) -> None:
        """List those that were saved."""
        menu.clear()
        for name in self._settings.layouts:
            item = menu.addAction(name.replace("&", "&&"))
            item.triggered.connect(lambda _checked=False, name=name: self._take(name))
        if menu.isEmpty():
            menu.addAction("None saved yet").setEnabled(False)

    def _take(self, name: str) -> None:
        layout = self._settings.layouts.get(name)
        if layout is not None:
            self.arrange(layout)

    def _ask_name(self) -> None:
        self._context.dialogs.ask_text("layout-name", "Save layout", "Name of this layout:", self._save)

    def _save(self, name: str) -> None:
        if name.strip():
            self._settings.save_layout(name.strip(), self.layout)
            self._context.notifier.status(f"Layout {name.strip()} saved; see View > Layouts")

    def _ask_which(self) -> None:
        names = list(self._settings.layouts)
        if names:
            text = "Which layout is not wanted any more?"
            self._context.dialogs.ask_choice(
                "layout-deleted", "Delete layout", text, names, self._settings.delete_layout
            )
        else:
            self._context.notifier.status("No layout was saved yet")
