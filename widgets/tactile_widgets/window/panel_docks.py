"""Undocked panels, and saved layouts of the window."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu, QScrollArea

from tactile_widgets.common.make import add_entry
from tactile_widgets.common.panel import SLIM_SCROLL_BAR, Panel
from tactile_widgets.common.settings import Settings, WindowLayout
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.panels.panel_column import COLUMN_WIDTH, PanelColumn
from tactile_widgets.plots.choice.plot_choice import PlotChoice
from tactile_widgets.window.more_views import MoreViews

_SCROLL_BAR_PX = 16
_TALLEST_PX = 640


class _PanelDock(QDockWidget):
    """Window of an undocked panel; closing it returns the panel to the column."""

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
        """Return the panel to the column."""
        super().closeEvent(event)
        self._docks.put_back(self)


class PanelDocks(QObject):
    """Undocks panels and returns them, and saves and applies layouts of panels, windows and views.

    Args:
        window: Window of the docks.
        column: Column of the panels.
        views: Optional views, which belong to a layout too.
        context: Session, views, panels and services of the window.
    """

    arranged = Signal()
    """Another layout was applied, which may show or hide docks."""

    def __init__(self, window: QMainWindow, column: PanelColumn, views: MoreViews, context: AppContext) -> None:
        super().__init__(window)
        self._window = window
        self._column = column
        self._views = views
        self._context = context
        self._docks: list[_PanelDock] = []
        column.undock_requested.connect(self.toggle)
        context.actions.bind(save_layout=self._ask_name, delete_layout=self._ask_which)

    @property
    def _settings(self) -> Settings:
        return self._context.settings

    def toggle(self, panel: Panel) -> None:
        """Undock ``panel`` next to the column, or return it."""
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
        """Return the panel of a closed dock to the column."""
        if dock in self._docks:
            self._docks.remove(dock)
            area = dock.widget()
            assert isinstance(area, QScrollArea)
            area.takeWidget()
            self._column.put_back(dock.panel)
            self._window.removeDockWidget(dock)
            dock.setObjectName("removed")  # a layout finds docks by name, and would show it again
            dock.deleteLater()

    # Layouts.

    @property
    def layout(self) -> WindowLayout:
        """Current layout."""
        undocked = tuple(dock.panel.objectName() for dock in self._docks)
        plots = self._context.plots.choice.to_text()
        return WindowLayout(undocked, self._column.folded, self._window.saveState(), plots, self._views.added)

    def arrange(self, layout: WindowLayout) -> None:
        """Apply a layout; unknown panels are left out."""
        self.gather()
        for panel in self._column:
            if panel.objectName() in layout.undocked:
                self._undock(panel)
        self._column.set_folded(layout.folded)
        self._views.add(layout.views)  # before the positions of the docks, as the second view is docked
        self._window.restoreState(layout.state)
        self._context.plots.choose(PlotChoice.from_text(layout.plots))
        self.arranged.emit()

    def reset(self) -> None:
        """Return all panels to the column and remove the optional views."""
        self.gather()
        self._views.add(())

    def gather(self) -> None:
        """Return all panels to the column."""
        for dock in tuple(self._docks):
            dock.close()

    def list_layouts(self, menu: QMenu) -> None:
        """List the saved layouts."""
        menu.clear()
        for name in self._settings.layouts:
            add_entry(menu, name, partial(self._take, name))
        if menu.isEmpty():
            menu.addAction("No saved layouts").setEnabled(False)

    def _take(self, name: str) -> None:
        layout = self._settings.layouts.get(name)
        if layout is not None:
            self.arrange(layout)

    def _ask_name(self) -> None:
        self._context.dialogs.ask_text("layout-name", "Save layout", "Name of this layout:", self._on_named)

    def _on_named(self, text: str) -> None:
        """Save the layout; ask before it replaces another."""
        name = text.strip()
        if not name:
            self._context.notifier.say("The layout was not saved, because its name is blank.", of="layouts")
        elif name in self._settings.layouts:
            question = f"There is a layout {name} already. Replace it?"
            self._context.dialogs.ask_button(
                "layout-replaced", "Save layout", question, ["Replace"], lambda _answer: self._save(name)
            )
        else:
            self._save(name)

    def _save(self, name: str) -> None:
        self._settings.save_layout(name, self.layout)
        self._context.notifier.status(f"Layout {name} saved; see View > Layouts")

    def _ask_which(self) -> None:
        names = list(self._settings.layouts)
        if names:
            text = "Layout to delete:"
            self._context.dialogs.ask_choice(
                "layout-deleted", "Delete layout", text, names, self._settings.delete_layout
            )
        else:
            self._context.notifier.say("No layout is saved: View > Save layout… saves the current one.", of="layouts")
