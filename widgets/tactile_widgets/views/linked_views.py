"""The robot view and the map view side by side, with a shared pointer, selection, pressure scale and state."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial

import numpy as np
from PySide6.QtCore import QPoint, QPointF, Qt, QTimer, Signal
from PySide6.QtWidgets import QSplitter, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import column_layout, make, row_layout
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.sentence import capitalized
from tactile_widgets.common.settings import BaseLayer, NavigationStyle, OverlayOptions
from tactile_widgets.common.tool_kinds import BRUSH, POKE, SelectionMode, ToolKind, resized_brush
from tactile_widgets.document.taxel_search import taxel_words
from tactile_widgets.document.taxel_selection import SelectionUpdate, TaxelSelection
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, TaxelFaults
from tactile_widgets.views.colour_bar import ColourBar
from tactile_widgets.views.interaction.view_interaction import ViewInteraction
from tactile_widgets.views.interaction.view_tool import PointedAt, ViewTool
from tactile_widgets.views.layers import LAYERS, LayerSpec, at_first, body_layers, map_layers
from tactile_widgets.views.map.map_view import MapView
from tactile_widgets.views.overlays.painting import PAUSED, PRESENT, REPLAYING, ViewState
from tactile_widgets.views.overlays.task_overlay_builder import TaskOverlayBuilder
from tactile_widgets.views.robot.robot_view import RobotView

_NARROWEST = 250
"""Minimum width of a view [px]: a window of 900 px then shows both views and the panels."""


class LinkedViews(QWidget):
    """Robot view, colour bar and map view. Selections and the pointer in one view are shown in the other."""

    menu_requested = Signal(PointedAt, QPoint)
    """Right click in either view: what is under the pointer, and its position on the screen."""
    overlays_changed = Signal(OverlayOptions)
    """Other layers are shown."""
    navigation_changed = Signal(NavigationStyle)
    """Other buttons move the camera."""
    faults_changed = Signal(TaxelFaults)
    """Other taxels are marked as faulty."""
    selection_described = Signal(str)
    """Number of selected taxels, or the name of a single one; empty without any."""

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Sequence[LayerSpec] = LAYERS,
        off_screen: bool = False,
    ) -> None:
        super().__init__(parent)
        if off_screen:  # for pictures that no display shows
            self.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self.robot = RobotView(theme, scale, layers=body_layers(layers), off_screen=off_screen)
        self.map = MapView(theme, scale, layers=map_layers(layers))
        self.bar = ColourBar(theme, scale)
        self.scale = scale
        self.navigation = NavigationStyle.STANDARD
        self.selection = TaxelSelection(self)
        self.tool = POKE
        self.selection.changed.connect(self._on_selection_changed)
        self.brush = BRUSH
        self.overlays = at_first(layers)
        self._task = TaskOverlayBuilder()
        self.faults = NO_FAULTS
        self._mode = Mode.EMPTY
        self._gap = ""
        self._state = PRESENT
        self._waiting: Frame | None = None
        self._map_ms = 0.0
        self._paced = False
        self._pace = make(QTimer, self, singleShot=True, timeout=self._show_waiting)
        self._lay_out()
        self.bar.maximum_changed.connect(self._on_maximum_changed)
        self.map.picture_changed.connect(self._overlay_body)
        self._show_overlays()
        for view, other in ((self.robot, self.map), (self.map, self.robot)):
            gestures = view.interaction
            gestures.taxel_selector.chosen.connect(self.selection.take)
            gestures.taxel_selector.abandoned.connect(self.selection.abandon)
            gestures.cleared.connect(self.selection.clear)
            gestures.hovered.connect(other.set_hover)
            gestures.menu_requested.connect(partial(self._on_menu_requested, view))
        self.robot.interaction.hovered.connect(self.map.describe)

    @property
    def interactions(self) -> tuple[ViewInteraction, ViewInteraction]:
        """The gestures on both views; their signals report what the user does."""
        return self.robot.interaction, self.map.interaction

    def _lay_out(self) -> None:
        right = self._right = QWidget()
        row_layout(self.bar, self.map, parent=right, spacing=0, stretch=self.map)
        self._splitter = QSplitter(Qt.Orientation.Horizontal)
        self._splitter.setChildrenCollapsible(False)
        self._splitter.setHandleWidth(1)
        for side in (self.robot, right):
            side.setMinimumWidth(_NARROWEST)
            self._splitter.addWidget(side)
        column_layout(self._splitter, parent=self)
        self.level()

    def show_only(self, *, robot: bool, map_: bool) -> None:
        """Show one or both views without a minimum width, and always the colour bar; for figures."""
        self.robot.setVisible(robot)
        self.map.setVisible(map_)
        for side in (self.robot, self._right):
            side.setMinimumWidth(0)
        if not map_:
            self._right.setFixedWidth(self.bar.sizeHint().width())

    def level(self) -> None:
        """Give both views the same width."""
        self._splitter.setSizes([1000, 1000])

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show another robot and its map."""
        self._waiting = None
        self.robot.show_prepared(prepared)
        self.map.show_prepared(prepared)
        self.selection.reset(len(prepared.skin))
        self._overlay_body()
        self._task.show_map(prepared.map)

    def set_paced(self, *, on: bool) -> None:
        """Set whether frames wait until both views can show them; frames in between are dropped for both."""
        self._paced = on

    def show_frame(self, frame: Frame) -> None:
        """Show a frame in both views; while one of them is busy, only the newest frame is kept.

        The map alone could be updated earlier, but would then show another time than the robot.
        """
        self._waiting = frame
        self._show_waiting()

    def _show_waiting(self) -> None:
        frame = self._waiting
        if frame is None:
            return
        # The map is painted while the robot view rests, so that its picture can follow at once.
        rest = self.robot.display.rest_ms(frame, self._map_ms) if self._paced else 0.0
        if rest > 0:
            self._pace.start(int(np.ceil(rest)))
            return
        self._waiting = None
        self._pace.stop()
        start = time.perf_counter()
        self._task.show_frame(frame)
        self.map.show_frame(frame, task=self._task.shown)  # first, because the user compares it with the finger
        self.map.viewport().repaint()
        self._map_ms = 1e3 * (time.perf_counter() - start)
        self.robot.display.show_frame(frame)
        self.robot.display.show_task(self._task.shown)
        self.bar.set_units(frame.units)
        self.bar.set_peak(1e-3 * float(frame.pressures.max(initial=0.0)))
        if self._paced:
            self.robot.display.draw_soon()

    def show_overlaid(self, regions: Sequence[ContactRegion]) -> None:
        """Outline the contacts of a second recording on the map."""
        self.map.show_overlaid(regions)

    def show_settings(self, settings: ControlSettings) -> None:
        """Show the task of these controller settings."""
        self._task.show_settings(settings)
        self._show_task()

    def _show_task(self) -> None:
        self.map.show_task(self._task.shown)
        self.robot.display.show_task(self._task.shown)

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark faulty taxels in both views."""
        self.faults = faults
        for part in (self.map, self.robot.display):
            part.set_faults(faults)
        self.faults_changed.emit(faults)

    def show_loading(self, text: str, fraction: float) -> None:
        """Show the progress of preparing the first robot."""
        self.robot.card.show_loading(text, fraction)
        self.map.card.show_waiting()

    def show_last(self) -> None:
        """Show the previous content again, or the empty views."""
        for view in (self.robot, self.map):
            view.card.show_last()

    def show_mode(self, mode: Mode) -> None:
        """Mark both views as paused or replaying."""
        self._mode = mode
        self._show_state()

    def show_gap(self, text: str) -> None:
        """Mark running views as old, because no readings of a real skin are used; an empty text ends that."""
        self._gap = text
        self._show_state()

    def _show_state(self) -> None:
        state = {Mode.PAUSED: PAUSED, Mode.REPLAYING: REPLAYING}.get(self._mode, PRESENT)
        if self._gap and self._mode is Mode.RUNNING:
            state = ViewState(self._gap, "warning")
        if state != self._state:
            self._state = state
            for part in (self.robot.display, self.map):
                part.set_state(state)

    def set_overlays(self, overlays: OverlayOptions) -> None:
        """Show the layers selected under View > Overlay in both views."""
        self.overlays = overlays
        self._show_overlays()
        self.overlays_changed.emit(overlays)

    def _show_overlays(self) -> None:
        self.map.set_overlays(self.overlays)
        self.robot.display.show_layers(self.overlays.shown)
        self._overlay_body()

    def _overlay_body(self) -> None:
        """Texture the robot with the map's image if it has a background; pressure alone is drawn finer without it."""
        textured = self.overlays.base is not BaseLayer.PRESSURE
        self.robot.display.set_picture(self.map.skin_texture, textured=textured)

    def set_tool(self, tool: ToolKind) -> None:
        """Set the tool of both views."""
        self.tool = tool
        for view in (self.robot, self.map):
            view.set_tool(tool)

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Set the editing or control tool of both views; None for tools that do neither."""
        for view in (self.robot, self.map):
            view.set_view_tool(tool)

    def show_document(self, document: MapDocument, *, in_gesture: bool = False, led: bool = True) -> None:
        """Show the edited map of the same skin.

        Args:
            document: The map.
            in_gesture: More changes follow at once.
            led: Whether the controller uses this map.
        """
        if not in_gesture:
            # First, because the map's image is mapped onto the robot by the charts that the robot view has.
            self.robot.display.show_map(document.map)
        self.map.show_document(document, in_gesture=in_gesture)
        if not in_gesture:
            self._task.show_map(document.map, led=led)
            self._show_task()

    def resize_brush(self, steps: int) -> None:
        """Enlarge the brush by this number of steps; negative values shrink it."""
        self.brush = resized_brush(self.brush, steps)
        for view in (self.robot, self.map):
            view.interaction.taxel_selector.set_radius(self.brush)

    def frame_all(self) -> None:
        """Fit both views."""
        self.robot.frame_all()
        self.map.frame_all()

    def show_taxels(self, taxels: IntArray) -> None:
        """Select these taxels (k,), at least one, and show them in both views."""
        prepared = self.robot.display.prepared
        if prepared is not None:
            self.selection.take(SelectionUpdate(taxels, SelectionMode.REPLACE))
            self.map.frame_taxels(taxels)
            self.robot.display.look_at(prepared.skin.taxel_point(int(taxels[0])))

    def select_taxel(self, taxel: int) -> None:
        """Select this taxel only."""
        self.selection.take(SelectionUpdate(np.array([taxel]), SelectionMode.REPLACE))

    def frame_patch(self, at: SurfacePoint) -> None:
        """Show the patch of a skin location in both views, on the robot from above that location."""
        prepared = self.robot.display.prepared
        if prepared is not None:
            first, last = prepared.skin.first[at.patch : at.patch + 2]
            if last > first:
                self.map.frame_taxels(np.arange(first, last))
            self.robot.display.look_at(at)

    def frame_seam(self, patch: int, vertices: IntArray, places: FloatArray) -> None:
        """Show a seam in both views: vertices (k,) of a patch, and map points (n, 2) [m] of both sides."""
        self.map.frame_places(places)
        self.robot.display.frame_seam(patch, vertices)

    def set_navigation(self, style: NavigationStyle) -> None:
        """Set the buttons that move the camera."""
        self.navigation = style
        for gestures in self.interactions:
            gestures.style = style
        self.navigation_changed.emit(style)

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        for part in (self.robot.display, self.map, self.bar):
            part.set_theme(theme)

    def _on_menu_requested(self, view: RobotView | MapView, pixel: QPointF) -> None:
        self.menu_requested.emit(view.pointed_at(pixel), view.mapToGlobal(pixel.toPoint()))

    def _on_maximum_changed(self, kilopascals: float) -> None:
        self.scale = PressureScale(kilopascals)
        for part in (self.robot.display, self.map, self.bar):
            part.set_scale(self.scale)

    def _on_selection_changed(self) -> None:
        for part in (self.robot.display, self.map):
            part.set_selection(self.selection.taxels, self.selection.inks)
        taxels = self.selection.taxels
        words = f"{len(taxels)} taxels selected"
        prepared = self.robot.display.prepared
        if len(taxels) == 1 and prepared is not None:
            words = f"{capitalized(taxel_words(prepared.skin, int(taxels[0])))} selected"
        self.selection_described.emit(words if len(taxels) else "")
