"""Drawing of the robot in a view: newest frame, camera, captions, and the time of the next picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QObject, QPointF, Signal
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import RobotError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.frame import Frame
from tactile_maps.session.link_levels import LinkLevels
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, TaxelFaults
from tactile_widgets.views.interaction.navigation import CameraMotion, zoom_by
from tactile_widgets.views.interaction.select_gesture import RubberBand
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, SkinTexture, ToolMarks
from tactile_widgets.views.overlays.callouts import LABELLED
from tactile_widgets.views.overlays.painting import ViewState
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay
from tactile_widgets.views.robot.actors.camera import Viewpoint, framing, look_from, orbit, pan, zoom
from tactile_widgets.views.robot.actors.contact_marks import arrow_legend, ring_radius
from tactile_widgets.views.robot.actors.robot_actors import BodyLayerFactory, RobotActors
from tactile_widgets.views.robot.caption_overlay import CaptionOverlay, Captions, ForceCaption
from tactile_widgets.views.robot.plotter_widget import (
    SHORTEST_WAIT_MS,
    Canvas,
    ImageCanvas,
    RenderScheduler,
    make_canvas,
)

_NO_SIDE = 0.2
"""Length of the mean unit normal below which a line goes around a body rather than along one side."""
_STEEP = 0.05
"""Tangent of the minimum angle between viewing direction and vertical."""


class RobotDisplay(QObject):
    """Display of one prepared robot in a view; draws only while the view is visible and something changed.

    Args:
        view: Widget that it fills.
        theme: Colours of everything except the skin.
        scale: Colours of pressure.
        layers: Factories of the layers drawn on the body, by name.
        off_screen: Whether the pictures are not shown on a display.

    Attributes:
        canvas: Widget of the plotter, in the view.
        actors: Actors on the plotter.
        overlay: Captions, orientation cube and drawings of a tool, over the picture.
        prepared: The robot; None before the first one, and after ``close``.
    """

    drawn = Signal(float)
    """A picture was drawn; the time it took [ms]."""

    def __init__(
        self,
        view: QWidget,
        theme: Theme,
        scale: PressureScale,
        *,
        layers: Mapping[str, BodyLayerFactory] | None = None,
        off_screen: bool = False,
    ) -> None:
        super().__init__(view)
        self._view = view
        self._covered = False
        self._automatic = True
        self.prepared: PreparedScene | None = None
        self._frame: Frame | None = None
        self._mark: SurfacePoint | None = None
        self._captions = Captions()
        self._framed = True
        self._marks = NO_MARKS
        self._faults = NO_FAULTS
        self._task = NO_TASK
        self._task_is_new = False
        self.canvas: Canvas = ImageCanvas(view) if off_screen else make_canvas(view)
        self.actors = RobotActors(self.canvas.plotter, theme, scale, layers)
        self.overlay = CaptionOverlay(theme, view)
        self._drawing = RenderScheduler(self.canvas, self)
        self._drawing.due.connect(self._on_drawing_due)
        self._drawing.drawn.connect(self.drawn)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the robot of ``prepared`` in its home posture, fitted to the view."""
        self.actors.show_prepared(prepared)
        self.actors.set_marks(self._marks)
        self.actors.set_faults(self._faults)
        self.prepared = prepared
        self._frame = None
        self._mark = None
        self._task = NO_TASK
        self._task_is_new = False
        legend = arrow_legend(ReadingUnits.CALIBRATED)
        hidden = len(self.actors.hidden)
        self._captions = replace(self._captions, forces=(), legend=legend, hidden=hidden)
        self.frame_all()

    def show_frame(self, frame: Frame) -> None:
        """Show ``frame`` of the prepared scene in the next picture, unless a newer one follows."""
        if self.prepared is not None:
            self._frame = frame
            if not self.actors.shows(frame):
                self.request()

    def rest_ms(self, frame: Frame, ahead_ms: float) -> float:
        """Return the time until ``frame`` can be shown, ``ahead_ms`` before it is drawn [ms].

        It is 0 if the frame changes nothing, or the view is hidden.
        """
        if not self._visible or self.actors.shows(frame):
            return 0.0
        return self._drawing.rest_ms(ahead_ms)

    def set_frame_rate(self, most: int) -> None:
        """Set the maximum number of pictures per second."""
        self._drawing.shortest_ms = max(1e3 / most, SHORTEST_WAIT_MS)

    def show_task(self, task: TaskOverlay) -> None:
        """Show the controller's task; does nothing for the same object."""
        if task is not self._task:
            self._task = task
            self._task_is_new = True
            self.request()

    def show_layers(self, shown: frozenset[str]) -> None:
        """Show the layers of these names only."""
        self.actors.show_layers(shown)
        self.request()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark a skin location, such as that under the pointer in another view; None for no mark."""
        if at != self._mark:
            self._mark = at
            self.request()

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Draw a ring around each of these taxels (k,) in its colour."""
        self.actors.set_selection(taxels, inks)
        self.request()

    def set_preview(self, skin: Skin | None) -> None:
        """Show a skin that is being chosen instead of the present one; None for the present one."""
        self.actors.set_preview(skin)
        self.request()

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck and blind taxels, also of later skins."""
        self._faults = faults
        self.actors.set_faults(faults)
        self.request()

    def set_picture(self, picture: SkinTexture | None, *, textured: bool) -> None:
        """Set the map's image, shown on the skin if ``textured``, and always while the skin is flattened."""
        self.actors.set_picture(picture, textured=textured)
        self.request()

    def show_map(self, map_: TactileMap) -> None:
        """Use another map of the same skin."""
        if self.prepared is not None and map_ is not self.prepared.map:
            self.prepared = replace(self.prepared, map=map_)
            self.actors.show_map(map_)
            self.request()

    @property
    def takes_levels(self) -> bool:
        """Whether coarser links save time; a graphics card draws all links equally fast."""
        return self.canvas.in_software

    def set_link_levels(self, levels: LinkLevels | None) -> None:
        """Draw links no finer than the picture can show, with these surfaces; None for the links' meshes."""
        if self.takes_levels:
            self.actors.set_link_levels(levels)
            self.request()

    def set_marks(self, marks: ToolMarks) -> None:
        """Show the marks of a tool; does nothing for the same object."""
        if marks is not self._marks:
            self._marks = marks
            self.actors.set_marks(marks)
            self.request()

    def hide(self, bodies: frozenset[int]) -> None:
        """Hide these links, with their skin, and objects, numbered after the links; show all others, and a count."""
        self.actors.hide(bodies)
        self._show_captions(replace(self._captions, hidden=len(bodies)))
        self.request()

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        self.actors.set_theme(theme)
        self.overlay.set_theme(theme)
        self.request()

    def set_scale(self, scale: PressureScale) -> None:
        """Set the pressure scale."""
        self.actors.set_scale(scale)
        self.request()

    def set_state(self, state: ViewState) -> None:
        """Set the state that is marked."""
        self._show_captions(replace(self._captions, state=state))

    def frame_all(self) -> None:
        """Fit the whole robot to the view, also after changes of the view's size."""
        self._framed = True
        self.actors.frame_all(aspect=self.size[0] / max(self.size[1], 1))
        self.request()

    @property
    def framed(self) -> bool:
        """Whether the robot is fitted to the view: true until the user moves the camera."""
        return self._framed

    def look(self, viewpoint: Viewpoint) -> None:
        """Set the viewpoint that the user selected."""
        self._framed = False
        self.actors.look(viewpoint)
        self.request(moving=True)

    def navigate(self, step: QPointF, motion: CameraMotion) -> None:
        """Turn the view around its focus, or pan or zoom it, by a drag [px]."""
        view = self.actors.viewpoint
        if motion is CameraMotion.ZOOM:
            self.look(zoom(view, zoom_by(step.y())))
        else:
            move = orbit if motion is CameraMotion.TURN else pan
            self.look(move(view, step.x(), step.y(), self.size[1]))

    def look_at(self, at: SurfacePoint) -> None:
        """Show a skin location from outside, at the current distance of the camera."""
        shown = self.actors.point(at)
        if shown is not None:
            point, normal = shown
            view = self.actors.viewpoint
            self.look(look_from(replace(view, eye=view.eye + point - view.focus, focus=point), normal))

    def frame_body(self, number: int) -> None:
        """Show a link, or an object, numbered after the links, from the current side."""
        if self.prepared is None:
            return
        links = self.prepared.robot.links
        mesh = links[number].mesh if number < len(links) else self.prepared.objects[number - len(links)].mesh
        if mesh is not None and len(mesh.vertices):
            self._frame_points(mesh.vertices, self.actors.body_poses[number], None)

    def frame_seam(self, patch: int, vertices: IntArray) -> None:
        """Show a run of vertices (k,) of a patch's surface from outside."""
        if self.prepared is not None:
            skin = self.prepared.skin.patches[patch]
            pose = self.actors.poses[self.prepared.robot.link_index[skin.link]]
            outward = pose[:3, :3] @ skin.surface.vertex_normals[vertices].mean(axis=0)
            around = np.linalg.norm(outward) < _NO_SIDE  # the current side is as good as any
            self._frame_points(skin.surface.vertices[vertices], pose, None if around else outward)

    def _frame_points(self, points: FloatArray, pose: FloatArray, away: FloatArray | None) -> None:
        """Show points (k, 3) of a body with this pose from a direction (3,), or from the current side."""
        aspect = self.size[0] / max(self.size[1], 1)
        view = self.actors.viewpoint
        away = view.eye - view.focus if away is None else away
        upright = np.array([0.0, 0.0, 1.0])
        if np.linalg.norm(np.cross(away, upright)) < _STEEP * np.linalg.norm(away):  # no view is along the vertical
            away = away + _STEEP * np.linalg.norm(away) * np.array([1.0, 0.0, 0.0])
        world = points @ pose[:3, :3].T + pose[:3, 3]
        self.look(framing(world, away, aspect, view_angle=view.view_angle, fill=0.5))

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Return the pixel of a skin location, which may be hidden.

        Raises:
            RobotError: No robot is shown.
        """
        return QPointF(*self.actors.viewpoint.pixels(self._world(at), self.size)[0])

    def pixel_size(self, at: SurfacePoint | None) -> float:
        """Return the size of a pixel at a skin location, or at the camera's focus [m].

        Raises:
            RobotError: A location is given, and no robot is shown.
        """
        view = self.actors.viewpoint
        return self._pixel_at(view.focus if at is None else self._world(at), view)

    def _pixel_at(self, point: FloatArray, view: Viewpoint) -> float:
        """Size of a pixel of the picture from ``view`` at a point (3,) of the world [m]."""
        depth = float((point - view.eye) @ view.axes[2])
        return 2 * depth * float(np.tan(np.radians(view.view_angle) / 2)) / max(self.size[1], 1)

    def _world(self, at: SurfacePoint) -> FloatArray:
        """(3,) position of a skin location, world [m]."""
        if self.prepared is None:
            raise RobotError("no robot is shown", value=at, remedy="Show a prepared scene first")
        skin = self.prepared.skin
        pose = self.actors.poses[self.prepared.robot.link_index[skin.link(at)]]
        return pose[:3, :3] @ skin.position(at) + pose[:3, 3]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the view [px]."""
        return self._view.width(), self._view.height()

    def cover(self, covered: bool) -> None:
        """Set whether a placeholder covers the view; nothing is drawn below it."""
        self._covered = covered
        self.request()

    def set_automatic(self, *, automatic: bool) -> None:
        """Set whether changes are drawn soon, rather than only by ``draw_now``."""
        self._automatic = automatic

    def request(self, *, moving: bool = False) -> None:
        """Draw soon if the view is visible; ``moving`` while the user moves the camera."""
        if self._visible and self._automatic:
            self._drawing.request(moving=moving)

    @property
    def _visible(self) -> bool:
        return self._view.isVisible() and not self._covered and self.prepared is not None

    def draw_soon(self) -> None:
        """Draw a requested picture as soon as pending events are handled: the map shows that instant already."""
        self._drawing.hurry()

    def draw_now(self, *, quality: float = 1.0) -> None:
        """Draw without waiting, at ``quality`` times the resolution if possible; for pictures and tests."""
        self._drawing.now(quality=quality)

    def stop(self) -> None:
        """Cancel requested pictures."""
        self._drawing.stop()

    def resize(self) -> None:
        """Handle another size of the view; a fitted robot stays fitted."""
        self.overlay.setGeometry(self._view.rect())
        if self._framed:
            self.frame_all()
        self.request()

    def set_rubber_band(self, rubber_band: RubberBand) -> None:
        """Draw the outline of a selection gesture over the view."""
        self._show_captions(replace(self._captions, rubber_band=rubber_band))

    def close(self) -> None:
        """Release the graphics resources; nothing is drawn after this."""
        self._drawing.stop()
        self.prepared = None
        self.canvas.close_plotter()

    def _on_drawing_due(self, quality: float) -> None:
        if self._frame is not None and not self.actors.shows(self._frame):
            self.actors.show_frame(self._frame)
        if self._task_is_new:
            self._task_is_new = False
            self.actors.show_task(self._task)
        self.actors.set_hover(self._mark)
        self.actors.fit_depth()
        self.actors.fit_detail(self._view.height() * self._view.devicePixelRatioF() * quality)
        view = self.actors.viewpoint
        size = self.size
        units = ReadingUnits.CALIBRATED if self._frame is None else self._frame.units
        notes = () if self._frame is None else self._frame.notes
        forces = tuple(
            ForceCaption(
                view.pixels(arrow, size),
                self._task.force_words(region, units, notes),
                bool((arrow[0] - arrow[1]) @ (view.eye - arrow[1]) < 0),
                ring_radius(region) / self._pixel_at(arrow[1], view),
            )
            for arrow, region in self.actors.forces[:LABELLED]
            if view.in_front(arrow).all()
        )
        contacts = 0 if self._frame is None else len(self._frame.regions)
        self._show_captions(
            replace(
                self._captions,
                forces=forces,
                axes=view.axes,
                legend=arrow_legend(units),
                contacts=contacts,
                arrows=self.actors.arrows(view, size),
                layers=self.actors.legends,
            )
        )

    def _show_captions(self, captions: Captions) -> None:
        self._captions = captions
        self.overlay.show_captions(captions)
