"""Optional views: a second view of the robot in its own panel, and the contact enlarged in the robot view.

A view is created when it is switched on and deleted when it is switched off, so that hidden views cost nothing.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import partial

from PySide6.QtCore import QObject, Qt, QTimer
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu

from tactile_maps.session.frame import Frame
from tactile_maps.session.link_levels import LinkLevels
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import add_entry, make
from tactile_widgets.common.settings import NavigationStyle
from tactile_widgets.context.app_context import AppContext
from tactile_widgets.overlays.taxel_faults import TaxelFaults
from tactile_widgets.views.layers import LAYERS, body_layers
from tactile_widgets.views.robot.second_view import ContactInset, SecondView

_LEAST_WIDTH = 1200
"""Smallest width of a window with room for another view [px]."""
_MARGIN = 24


class _ViewDock(QDockWidget):
    """Dock of the second view; closing it removes the view."""

    def __init__(self, view: SecondView, window: QMainWindow, owner: MoreViews) -> None:
        super().__init__("Second view", window)
        self._owner = owner
        self.setObjectName("dock-second")
        self.setAllowedAreas(Qt.DockWidgetArea.LeftDockWidgetArea | Qt.DockWidgetArea.BottomDockWidgetArea)
        self.setWidget(view)

    def closeEvent(self, event: QCloseEvent) -> None:
        """Remove the view."""
        super().closeEvent(event)
        self._owner.show_second(shown=False)


class MoreViews(QObject):
    """Adds and removes the optional views, and keeps them synchronized with the robot view.

    Args:
        context: Session, views, panels and services of the window.
        window: Window in which the second view is docked.

    Attributes:
        second: Second view; None while it is off.
        inset: Enlarged contact; None while it is off.
    """

    def __init__(self, context: AppContext, window: QMainWindow) -> None:
        super().__init__(window)
        self._context = context
        self._window = window
        self.second: SecondView | None = None
        self.inset: ContactInset | None = None
        self._dock: _ViewDock | None = None
        self._refill = make(QTimer, self, singleShot=True, timeout=self._on_refill)
        actions = context.actions
        actions.bind(second_view=lambda: self.show_second(shown=actions["second_view"].isChecked()))
        actions.bind(contact_inset=lambda: self.show_inset(shown=actions["contact_inset"].isChecked()))
        session = context.session
        views = context.views
        session.prepared_changed.connect(self._on_prepared_changed)
        session.frame_ready.connect(self._on_frame_ready)
        session.scene_jobs.levels_made.connect(self._on_levels_made)
        context.theme.changed.connect(self._on_theme_changed)
        views.bar.maximum_changed.connect(self._on_scale_changed)
        views.navigation_changed.connect(self._on_navigation_changed)
        views.overlays_changed.connect(self._on_overlays_changed)
        views.faults_changed.connect(self._on_faults_changed)

    def show_second(self, *, shown: bool) -> None:
        """Add the second view, or remove it."""
        self._context.actions["second_view"].setChecked(shown)
        if shown and self.second is None:
            layers = body_layers(LAYERS)
            views = self._context.views
            self.second = SecondView(self._context.theme.theme, views.scale, layers=layers)
            self._dock = _ViewDock(self.second, self._window, self)
            self._window.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, self._dock)
            if self._window.width() < _LEAST_WIDTH:
                self._float(self._dock)
            self._dock.show()  # now: Qt would wait for the event loop, and a layout saved before that would hide it
            self.second.navigation = views.navigation
            self._fill(self.second)
        elif not shown and self.second is not None and self._dock is not None:
            dock = self._dock
            view = self.second
            self._dock = None
            self.second = None
            view.close_view()
            self._window.removeDockWidget(dock)
            dock.setObjectName("removed")  # a layout finds docks by name, and would show it again
            dock.deleteLater()

    def _float(self, dock: QDockWidget) -> None:
        """Float it over the lower left corner of the window, because there is no room next to the other views."""
        dock.setFloating(True)
        corner = self._window.mapToGlobal(self._window.rect().bottomLeft())
        dock.move(corner.x() + _MARGIN, corner.y() - dock.sizeHint().height() - _MARGIN)

    def show_inset(self, *, shown: bool) -> None:
        """Add or remove the enlarged contact."""
        self._context.actions["contact_inset"].setChecked(shown)
        robot = self._context.views.robot
        if shown and self.inset is None:
            self.inset = ContactInset(self._context.theme.theme, self._context.views.scale, robot)
            self.inset.look_requested.connect(robot.display.look_at)
            self.inset.show()
            self._fill(self.inset.view)
        elif not shown and self.inset is not None:
            inset = self.inset
            self.inset = None
            inset.close_view()
            inset.hide()
            inset.deleteLater()

    @property
    def added(self) -> tuple[str, ...]:
        """Names of the views that are on: ``second``, ``inset``."""
        views = (("second", self.second), ("inset", self.inset))
        return tuple(name for name, view in views if view is not None)

    def add(self, names: Collection[str]) -> None:
        """Show the views with these names, and no others."""
        self.show_second(shown="second" in names)
        self.show_inset(shown="inset" in names)

    def close(self) -> None:
        """Remove the views and release their graphics."""
        self._refill.stop()
        self.add(())

    def list_bodies(self, menu: QMenu) -> None:
        """List the links with a mesh, and the objects; choosing one frames it."""
        menu.clear()
        prepared = self._context.views.robot.display.prepared
        bodies = [] if prepared is None else [(link.name, link.mesh) for link in prepared.robot.links]
        bodies += [] if prepared is None else [(body.spec.name, body.mesh) for body in prepared.objects]
        for number, (name, mesh) in enumerate(bodies):
            if mesh is not None and len(mesh.vertices):
                words = name.replace("_", " ")
                tip = f"Frame {words} from the current viewing direction"
                frame = partial(self._context.views.robot.display.frame_body, number)
                add_entry(menu, words, frame, objectName=f"frame-{name}", toolTip=tip)
        if menu.isEmpty():
            menu.addAction("No robot yet").setEnabled(False)

    @property
    def _shown(self) -> tuple[SecondView, ...]:
        inset = None if self.inset is None else self.inset.view
        return tuple(view for view in (self.second, inset) if view is not None)

    def _fill(self, view: SecondView) -> None:
        session = self._context.session
        views = self._context.views
        view.display.show_layers(views.overlays.shown)
        view.display.set_faults(views.faults)
        view.display.set_link_levels(views.robot.display.actors.link_levels)
        if session.prepared is not None:
            view.show_prepared(session.prepared)
        if session.shown is not None:
            view.show_frame(session.shown)

    def _on_prepared_changed(self, _prepared: PreparedScene) -> None:
        if self._shown:
            self._refill.start(0)  # after other waiting events: the robot view has just been built

    def _on_refill(self) -> None:
        for view in self._shown:
            self._fill(view)

    def _on_frame_ready(self, frame: Frame) -> None:
        if not self._refill.isActive():  # otherwise it belongs to a scene that they do not show yet
            for view in self._shown:
                view.show_frame(frame)

    def _on_levels_made(self, levels: LinkLevels) -> None:
        for view in self._shown:
            view.display.set_link_levels(levels)

    def _on_theme_changed(self, theme: Theme) -> None:
        for view in self._shown:
            view.display.set_theme(theme)

    def _on_navigation_changed(self, style: NavigationStyle) -> None:
        if self.second is not None:
            self.second.navigation = style

    def _on_scale_changed(self, _maximum: float) -> None:
        for view in self._shown:
            view.display.set_scale(self._context.views.scale)

    def _on_faults_changed(self, faults: TaxelFaults) -> None:
        for view in self._shown:
            view.display.set_faults(faults)

    def _on_overlays_changed(self, _overlays: object) -> None:
        for view in self._shown:
            view.display.show_layers(self._context.views.overlays.shown)
