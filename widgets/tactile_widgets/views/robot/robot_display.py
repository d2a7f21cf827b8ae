"""What is drawn of the robot, and when: the newest frame when it is due, the camera kept, captions over it."""

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
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, TaxelFaults
from tactile_widgets.views.interaction.select_gesture import RubberBand
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, SkinTexture, ToolMarks
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay
from tactile_widgets.views.robot.caption_overlay import CaptionOverlay, Captions, ForceCaption
from tactile_widgets.views.robot.plotter_widget import Canvas, ImageCanvas, RenderScheduler, make_canvas
from tactile_widgets.views.robot.scene.camera import Viewpoint, framing, look_from
from tactile_widgets.views.robot.scene.contact_marks import arrow_legend, ring_radius
from tactile_widgets.views.robot.scene.robot_scene import BodyLayerFactory, RobotScene

_NO_SIDE = 0.2
"""Mean of unit normals below which a line runs around a body more than along one of its sides."""
_STEEP = 0.05
"""Tangent of the least angle from the vertical from which is looked."""


class RobotDisplay(QObject):
    """One prepared robot as of the newest frame, in a view; draws only while that is seen and something changed.

    Args:
        view: The widget that it fills.
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        layers: Makes each layer that is drawn on the body, by name.
        off_screen: Whether it is for pictures that no display shows.

    Attributes:
        canvas: Shows the plotter, in the view.
        scene: What is on it.
        overlay: Captions, orientation cube and what a tool paints, over the picture.
        prepared: The robot; None before there is one, and after ``close``.
    """

    drawn = Signal(float)
    """A picture was drawn: its milliseconds."""

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
        self.scene = RobotScene(self.canvas.plotter, theme, scale, layers)
        self.overlay = CaptionOverlay(theme, view)
        self._drawing = RenderScheduler(self.canvas, self)
        self._drawing.due.connect(self._on_drawing_due)
        self._drawing.drawn.connect(self.drawn)

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the robot of ``prepared`` at home, framed."""
        self.scene.show_prepared(prepared)
        self.scene.set_marks(self._marks)
        self.scene.set_faults(self._faults)
        self.prepared = prepared
        self._frame = None
        self._mark = None
        self._task = NO_TASK
        self._task_is_new = False
        legend = arrow_legend(ReadingUnits.CALIBRATED)
        hidden = len(self.scene.hidden)
        self._captions = replace(self._captions, forces=(), legend=legend, hidden=hidden)
        self.frame_all()

    def show_frame(self, frame: Frame) -> None:
        """Show ``frame`` of the prepared scene at the next chance to draw; the newest wins."""
        if self.prepared is not None:
            self._frame = frame
            if not self.scene.shows(frame):
                self.request()

    def rest_ms(self, frame: Frame) -> float:
        """For how long ``frame`` cannot be drawn yet; 0 where it can, looks as what is shown, or nobody sees it."""
        if not self._seen or self.scene.shows(frame):
            return 0.0
        return self._drawing.rest_ms

    def show_task(self, task: TaskOverlay) -> None:
        """Show what a controller with a task wants, and what came of it; nothing for the same again."""
        if task is not self._task:
            self._task = task
            self._task_is_new = True
            self.request()

    def show_layers(self, shown: frozenset[str]) -> None:
        """Show the layers of these names and no others."""
        self.scene.show_layers(shown)
        self.request()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark a place on the skin, such as the one the pointer is over in another view; None for none."""
        if at != self._mark:
            self._mark = at
            self.request()

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        self.scene.set_selection(taxels, inks)
        self.request()

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck and blind taxels, of this skin and those after it."""
        self._faults = faults
        self.scene.set_faults(faults)
        self.request()

    def set_picture(self, picture: SkinTexture | None, *, textured: bool) -> None:
        """Take the map's picture: shown while ``textured``, else kept for the way to the map."""
        self.scene.set_picture(picture, textured=textured)
        self.request()

    def show_map(self, map_: TactileMap) -> None:
        """The same skin on another map: what was flattened otherwise is drawn by it from now on."""
        if self.prepared is not None and map_ is not self.prepared.map:
            self.prepared = replace(self.prepared, map=map_)
            self.scene.show_map(map_)
            self.request()

    @property
    def takes_levels(self) -> bool:
        """Whether coarser links save time here: a graphics card draws all of them as fast."""
        return self.canvas.in_software

    def set_link_levels(self, levels: LinkLevels | None) -> None:
        """Draw links no finer than the picture can show, of the robot that these are of; None for as they are."""
        if self.takes_levels:
            self.scene.set_link_levels(levels)
            self.request()

    def set_marks(self, marks: ToolMarks) -> None:
        """Show what an edit tool marks on the body; nothing for the same again."""
        if marks is not self._marks:
            self._marks = marks
            self.scene.set_marks(marks)
            self.request()

    def hide(self, bodies: frozenset[int]) -> None:
        """Leave out these links, with their skin, and objects behind the links, and no others; say how many."""
        self.scene.hide(bodies)
        self._say(replace(self._captions, hidden=len(bodies)))
        self.request()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.scene.set_theme(theme)
        self.overlay.set_theme(theme)
        self.request()

    def set_scale(self, scale: PressureScale) -> None:
        """Take another pressure scale."""
        self.scene.set_scale(scale)
        self.request()

    def set_replaying(self, *, replaying: bool) -> None:
        """Mark everything shown as replayed from a recording, or as live again."""
        self._say(replace(self._captions, replaying=replaying))

    def set_paused(self, *, paused: bool) -> None:
        """Say that time stands still, or runs again."""
        self._say(replace(self._captions, paused=paused))

    def frame_all(self) -> None:
        """Look at the whole robot again, and keep it whole while the view is resized."""
        self._framed = True
        self.scene.frame_all(aspect=self.size[0] / max(self.size[1], 1))
        self.request()

    @property
    def framed(self) -> bool:
        """Whether the whole robot is kept in sight; no longer once the user has moved the eye."""
        return self._framed

    def look(self, viewpoint: Viewpoint) -> None:
        """Look from where the user moved the eye."""
        self._framed = False
        self.scene.look(viewpoint)
        self.request(moving=True)

    def look_at(self, at: SurfacePoint) -> None:
        """Look at a place on the skin from outside, as far from it as the eye is from its focus now."""
        shown = self.scene.point(at)
        if shown is not None:
            point, normal = shown
            view = self.scene.viewpoint
            self.look(look_from(replace(view, eye=view.eye + point - view.focus, focus=point), normal))

    def frame_body(self, number: int) -> None:
        """Look at a link, or at an object behind the links, from the side it is seen from now."""
        if self.prepared is None:
            return
        links = self.prepared.robot.links
        pose = self.scene.body_poses[number]
        mesh = links[number].mesh if number < len(links) else self.prepared.objects[number - len(links)].mesh
        if mesh is not None and len(mesh.vertices):
            view = self.scene.viewpoint
            self._frame_points(mesh.vertices @ pose[:3, :3].T + pose[:3, 3], view.eye - view.focus)

    def frame_seam(self, patch: int, vertices: IntArray) -> None:
        """Look at a run of vertices (k,) of a patch's surface, from outside."""
        if self.prepared is not None:
            skin = self.prepared.skin
            surface = skin.patches[patch].surface
            pose = self.scene.poses[self._link_of(patch)]
            outward = pose[:3, :3] @ surface.vertex_normals[vertices].mean(axis=0)
            if np.linalg.norm(outward) < _NO_SIDE:  # it runs around the link: from where the eye is
                outward = self.scene.viewpoint.eye - self.scene.viewpoint.focus
            self._frame_points(surface.vertices[vertices] @ pose[:3, :3].T + pose[:3, 3], outward)

    def _link_of(self, patch: int) -> int:
        assert self.prepared is not None
        return self.prepared.robot.link_index[self.prepared.skin.patches[patch].link]

    def _frame_points(self, points: FloatArray, away: FloatArray) -> None:
        aspect = self.size[0] / max(self.size[1], 1)
        upright = np.array([0.0, 0.0, 1.0])
        if np.linalg.norm(np.cross(away, upright)) < _STEEP * np.linalg.norm(away):  # no view is along the vertical
            away = away + _STEEP * np.linalg.norm(away) * np.array([1.0, 0.0, 0.0])
        angle = self.scene.viewpoint.view_angle
        self.look(framing(points, away, aspect, view_angle=angle, fill=0.5))

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Where a place on the skin is in this view now [px]; it may be hidden behind something.

        Raises:
            RobotError: No robot is shown.
        """
        return QPointF(*self.scene.viewpoint.pixels(self._world(at), self.size)[0])

    def pixel_size(self, at: SurfacePoint | None) -> float:
        """How large a pixel is at a place on the skin, or where the eye looks [m].

        Raises:
            RobotError: A place is given, and no robot is shown.
        """
        return self._pixel_at(self.scene.viewpoint.focus if at is None else self._world(at))

    def _pixel_at(self, point: FloatArray) -> float:
        """How large a pixel is at a point (3,) of the world [m]."""
        view = self.scene.viewpoint
        depth = float((point - view.eye) @ view.axes[2])
        return 2 * depth * float(np.tan(np.radians(view.view_angle) / 2)) / max(self.size[1], 1)

    def _world(self, at: SurfacePoint) -> FloatArray:
        """(3,) where a place on the skin is [m]."""
        if self.prepared is None:
            raise RobotError("there is no robot to find the point on", value=at, remedy="Show a prepared scene first")
        skin = self.prepared.skin
        pose = self.scene.poses[self.prepared.robot.link_index[skin.link(at)]]
        return pose[:3, :3] @ skin.position(at) + pose[:3, 3]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the view [px]."""
        return self._view.width(), self._view.height()

    def cover(self, covered: bool) -> None:
        """A message covers the view, or no longer: what nobody sees is not drawn."""
        self._covered = covered
        self.request()

    def request(self, *, moving: bool = False) -> None:
        """Draw soon, if seen; ``moving`` while the user moves the eye."""
        if self._seen:
            self._drawing.request(moving=moving)

    @property
    def _seen(self) -> bool:
        return self._view.isVisible() and not self._covered and self.prepared is not None

    def draw_soon(self) -> None:
        """Draw what was requested as soon as Qt has done what waits: the map shows that instant already."""
        self._drawing.hurry()

    def draw_now(self, *, quality: float = 1.0) -> None:
        """Draw without waiting, at ``quality`` times the resolution where possible; for pictures and tests."""
        self._drawing.now(quality=quality)

    def stop(self) -> None:
        """Draw nothing of what was requested."""
        self._drawing.stop()

    def resize(self) -> None:
        """The view has another size: what was framed stays framed."""
        self.overlay.setGeometry(self._view.rect())
        if self._framed:
            self.frame_all()
        self.request()

    def set_rubber_band(self, rubber_band: RubberBand) -> None:
        """Draw what a gesture draws over the view."""
        self._say(replace(self._captions, rubber_band=rubber_band))

    def close(self) -> None:
        """Give the graphics back; nothing is drawn after this."""
        self._drawing.stop()
        self.prepared = None
        self.canvas.close_plotter()

    def _on_drawing_due(self, quality: float) -> None:
        if self._frame is not None and not self.scene.shows(self._frame):
            self.scene.show_frame(self._frame)
        if self._task_is_new:
            self._task_is_new = False
            self.scene.show_task(self._task)
        self.scene.set_hover(self._mark)
        self.scene.fit_depth()
        self.scene.fit_detail(self._view.height() * self._view.devicePixelRatioF() * quality)
        view = self.scene.viewpoint
        size = self.size
        units = ReadingUnits.CALIBRATED if self._frame is None else self._frame.units
        forces = tuple(
            ForceCaption(
                view.pixels(arrow, size),
                self._task.force_words(region, units),
                bool((arrow[0] - arrow[1]) @ (view.eye - arrow[1]) < 0),
                ring_radius(region) / self._pixel_at(arrow[1]),
            )
            for arrow, region in self.scene.forces
            if view.in_front(arrow).all()
        )
        self._say(replace(self._captions, forces=forces, axes=view.axes, legend=arrow_legend(units)))

    def _say(self, captions: Captions) -> None:
        self._captions = captions
        self.overlay.say(captions)
