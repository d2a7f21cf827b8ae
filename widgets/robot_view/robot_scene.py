"""The robot as actors on any PyVista plotter: built once a robot, then updated in place."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonMath import vtkMatrix4x4

from app.arrays import FloatArray
from app.geometry.mesh import Mesh
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_image import vertex_weights
from app.robots.configuration import Configuration
from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.colours import PressureScale, Theme, mixed
from widgets.robot_view.marks import Marks
from widgets.robot_view.viewpoint import Viewpoint, framing

_STILL = 2e-5
"""Joints that move less [rad, m] do not change a pixel."""
_AWAY = np.array([0.45, 0.95, 0.42])
"""From the robot to the eye: its front is +x, z is up, and the side is that of a left arm."""


class RobotScene:
    """Links, skin, contacts and fingers of one prepared scene. Mutable; ``show_prepared`` replaces everything.

    Args:
        plotter: Where to draw; its actors are this scene's alone.
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
    """

    def __init__(self, plotter: Any, theme: Theme, scale: PressureScale) -> None:
        self._plotter, self._theme, self._scale = plotter, theme, scale
        self._prepared: Prepared | None = None
        self._frame: Frame | None = None
        self._links: list[tuple[int, Any]] = []
        self._bodies: list[Any] = []
        self._bounds: list[FloatArray] = []
        self._skins: list[tuple[pv.PolyData, Any]] = []
        self._light_and_ground()

    def show_prepared(self, prepared: Prepared) -> None:
        """Draw another robot, at home, framed."""
        self._plotter.clear_actors()
        self._prepared, self._frame = prepared, None
        self._configuration = Configuration(prepared.robot)
        self._links, self._bodies, self._skins, self._bounds = [], [], [], []
        for number, link in enumerate(prepared.robot.links):
            if link.mesh is not None and len(link.mesh.faces):
                actor = self._plotter.add_mesh(_polydata(link.mesh), color=self._theme.body, **_MATTE)
                self._links.append((number, actor))
                self._bodies.append(actor)
                self._bounds.append(link.mesh.bounds)
        weights = vertex_weights(prepared.map)
        for patch, matrix in zip(prepared.skin.patches, weights, strict=True):
            surface = _polydata(patch.surface)
            surface.point_data["touch"] = self._scale.rgb(np.zeros(len(patch.surface.vertices)))
            actor = self._plotter.add_mesh(surface, scalars="touch", rgb=True, copy_mesh=False, **_MATTE)
            self._links.append((prepared.robot.link_index[patch.link], actor))
            self._skins.append((surface, matrix))
            self._bounds.append(patch.surface.bounds)
        self._marks = Marks(self._plotter, self._theme, prepared)
        self._move()
        self._ground()
        self.frame_all()
        self.fit_depth()

    def show_frame(self, frame: Frame) -> None:
        """Move links and colour skin, in place; the caller renders."""
        if self._prepared is None:
            return
        self._frame = frame
        self._configuration.update(frame.posture)
        self._move()
        self._colour(frame.pressures)
        self._marks.show_frame(frame, self.poses)

    def shows(self, frame: Frame) -> bool:
        """Whether ``frame`` would look like the one shown: an arm at rest need not be drawn again and again."""
        shown = self._frame
        return shown is not None and (
            shown is frame
            or (
                bool(np.abs(frame.posture - shown.posture).max(initial=0.0) < _STILL)
                and bool(np.abs(frame.pressures - shown.pressures).max(initial=0.0) < 1e3 * self._scale.maximum / 256)
                and len(frame.pokes) == len(shown.pokes)
                and [f"{r.id} {r.force:.2f}" for r in frame.regions] == [f"{r.id} {r.force:.2f}" for r in shown.regions]
            )
        )

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark a place on the skin; None for none."""
        if self._prepared is not None:
            self._marks.set_hover(at, self.poses)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._plotter.set_background(theme.window)
        for actor in self._bodies:
            actor.prop.color = theme.body
        if self._prepared is not None:
            self._marks.set_theme(theme)
            self._ground()

    def set_scale(self, scale: PressureScale) -> None:
        """Take another pressure scale."""
        self._scale = scale
        if self._prepared is not None:
            self._colour(np.zeros(len(self._prepared.skin)) if self._frame is None else self._frame.pressures)

    @property
    def poses(self) -> FloatArray:
        """(links, 4, 4) ``T_world_link`` as drawn."""
        return self._configuration.poses()

    @property
    def forces(self) -> list[tuple[FloatArray, float]]:
        """Each force arrow's tail and tip (2, 3) [m], world, and the force it stands for [N]."""
        return self._marks.forces if self._prepared is not None else []

    @property
    def viewpoint(self) -> Viewpoint:
        """Where the eye is."""
        return Viewpoint.of(self._plotter.camera)

    def look(self, viewpoint: Viewpoint) -> None:
        """Look from there."""
        viewpoint.to(self._plotter.camera)
        self._plotter.camera.is_set = True  # or PyVista would look from its own default place at the first render

    def frame_all(self, *, aspect: float | None = None) -> None:
        """Look at everything, three quarters from the front and slightly from above.

        Args:
            aspect: Width by height of the picture; by default the plotter's.
        """
        if self._prepared is not None:
            width, height = self._plotter.window_size
            points = self._corners()
            self.look(framing(points, _AWAY, aspect or width / height, view_angle=30.0, fill=0.86))

    def fit_depth(self) -> None:
        """Let the camera's depth hold all that is drawn; before each picture, since the robot moves."""
        self._plotter.renderer.ResetCameraClippingRange()

    def _corners(self) -> FloatArray:
        """(k, 3) corners of all links' and patches' boxes, world [m]."""
        poses = self.poses
        parts = []
        for (number, _), bounds in zip(self._links, self._bounds, strict=True):
            corners = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T
            parts.append(corners @ poses[number][:3, :3].T + poses[number][:3, 3])
        return np.concatenate(parts)

    def _move(self) -> None:
        poses = self.poses
        for number, actor in self._links:
            matrix = actor.GetUserMatrix()
            if matrix is None:
                matrix = vtkMatrix4x4()
                actor.SetUserMatrix(matrix)
            matrix.DeepCopy(poses[number].ravel())

    def _colour(self, pressures: FloatArray) -> None:
        kilopascals = 1e-3 * pressures
        for surface, matrix in self._skins:
            colours = surface.point_data["touch"]
            colours[:] = self._scale.rgb(matrix @ kilopascals)
            surface.GetPointData().GetArray("touch").Modified()

    def _light_and_ground(self) -> None:
        self._plotter.set_background(self._theme.window)
        self._plotter.remove_all_lights()
        # One headlight, a little above the eye, so that shape shows without hiding colour.
        self._plotter.add_light(pv.Light(position=(0.25, 0.45, 1.0), light_type="camera light", intensity=0.95))

    def _ground(self) -> None:
        """A faint grid on the floor, as large as the robot needs."""
        points = self._corners()
        span = float(np.clip(np.ptp(points[:, :2], axis=0).max(), 0.2, 20.0))
        step = 10.0 ** np.floor(np.log10(span / 2))
        half = step * np.ceil(0.9 * span / step)
        centre = np.round(points[:, :2].mean(axis=0) / step) * step
        ticks = np.arange(-half, half + step / 2, step)
        ends = [[[t, -half], [t, half]] for t in ticks] + [[[-half, t], [half, t]] for t in ticks]
        floor = min(float(points[:, 2].min()), 0.0) if points[:, 2].min() < -1e-3 else 0.0
        lines = np.concatenate([np.array(ends).reshape(-1, 2) + centre, np.full((2 * len(ends), 1), floor)], axis=1)
        grid = pv.PolyData(lines, lines=np.insert(np.arange(len(lines)).reshape(-1, 2), 0, 2, axis=1).ravel())
        colour = mixed(self._theme.window, self._theme.quiet, 0.28)
        self._plotter.add_mesh(
            grid, color=colour, line_width=1, lighting=False, name="ground", pickable=False, reset_camera=False
        )


_MATTE: dict[str, Any] = {
    "smooth_shading": True,
    "split_sharp_edges": False,
    "ambient": 0.34,
    "diffuse": 0.70,
    "specular": 0.0,
    "show_scalar_bar": False,
    "reset_camera": False,
}


def _polydata(mesh: Mesh) -> pv.PolyData:
    """The mesh for VTK, with its own area-weighted normals, so that VTK computes none."""
    surface = pv.PolyData.from_regular_faces(mesh.vertices.copy(), mesh.faces.copy())
    surface.point_data.active_normals = mesh.vertex_normals.copy()
    return surface
