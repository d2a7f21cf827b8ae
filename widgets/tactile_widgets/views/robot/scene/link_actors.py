"""The bare links as actors, each as fine as the picture can show: coarser where its triangles are below a pixel.

``LinkActors`` alone decides which surface of a link is shown. Whatever is picked or measured is the link's mesh.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.remesh.simplify import coarse_mesh
from tactile_maps.robots.model.robot import Robot
from tactile_maps.session.link_levels import LinkLevels, links_digest
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.robot.scene.camera import Viewpoint
from tactile_widgets.views.robot.scene.surface_marks import add_surface, polydata

PIXELS = 0.5
"""A surface is shown while it is nearer to the link's own than so many pixels."""


class LinkActors:
    """One actor a link that has a mesh. Mutable: ``set_levels`` and ``choose`` say which surface it shows.

    Args:
        plotter: Where to draw.
        robot: Whose links.
        theme: Its body's colour, and its warnings' for stand-ins of missing meshes.

    Attributes:
        placed: Link number and actor of each.
        shown: The level of each of these: 0 for the link's own mesh, and rising with the error.
    """

    def __init__(self, plotter: Any, robot: Robot, theme: Theme) -> None:
        self._robot = robot
        self.placed: list[tuple[int, Any]] = []
        self._bodies: list[Any] = []
        self._placeholders: list[Any] = []
        self._solids: frozenset[Any] = frozenset()
        self._surfaces: list[dict[int, pv.PolyData]] = []
        balls = []
        for number, link in enumerate(robot.links):
            if link.mesh is not None and len(link.mesh.faces):
                body = polydata(link.mesh.vertices, link.mesh.vertex_normals, link.mesh.faces)
                actor = add_surface(plotter, body, theme.body)
                self.placed.append((number, actor))
                self._surfaces.append({0: body})
                (self._placeholders if link.missing else self._bodies).append(actor)
                if link.mesh.is_solid:
                    self._solids |= {actor}
                    actor.prop.culling = "back"  # saves a third of the time to draw it
                balls.append([*link.mesh.bounds.mean(axis=0), 0.5 * link.mesh.size])
        self._balls = np.array(balls).reshape(-1, 4)  # around each link: middle in its frame, radius [m]
        self.shown = np.zeros(len(self.placed), int)
        self._levels: LinkLevels | None = None
        self._errors = np.zeros((len(self.placed), 1))
        self.set_theme(theme)

    def set_levels(self, levels: LinkLevels | None) -> None:
        """Have these coarser surfaces from the next ``choose`` on; those of another robot count as none."""
        fits = levels is not None and levels.digest == links_digest(self._robot)
        self._levels = levels if fits else None
        own = [() if self._levels is None else self._levels.links[number] for number, _ in self.placed]
        self._errors = np.full((len(own), 1 + max(map(len, own), default=0)), np.inf)
        self._errors[:, 0] = 0.0
        for errors, surfaces in zip(self._errors, own, strict=True):
            errors[1 : 1 + len(surfaces)] = [surface.error for surface in surfaces]
        for row in range(len(own)):
            self._show(row, 0)
        self._surfaces = [{0: made[0]} for made in self._surfaces]

    def choose(self, view: Viewpoint, height: float, poses: FloatArray) -> None:
        """Show of each link the coarsest surface whose error is below ``PIXELS`` where the link is nearest to the eye.

        Args:
            view: From where it is seen.
            height: Of the picture [px].
            poses: (links, 4, 4) ``T_world_link``.

        Cost: 50 µs for 40 links; 1 ms for each that shows another.
        """
        if self._levels is None:
            return
        own = poses[[number for number, _ in self.placed]]
        middles = np.einsum("nij,nj->ni", own[:, :3, :3], self._balls[:, :3]) + own[:, :3, 3]
        nearest = (middles - view.eye) @ view.axes[2] - self._balls[:, 3]
        pixel = 2 * np.maximum(nearest, 0.0) * np.tan(np.radians(view.view_angle) / 2) / max(height, 1.0)
        wanted = (self._errors <= PIXELS * pixel[:, None]).sum(axis=1) - 1
        for row in np.flatnonzero(wanted != self.shown):
            self._show(int(row), int(wanted[row]))

    def _show(self, row: int, level: int) -> None:
        number, actor = self.placed[row]
        known = self._surfaces[row]
        mesh = self._robot.links[number].mesh
        if level not in known and self._levels is not None and mesh is not None:
            coarse, _ = coarse_mesh(mesh, self._levels.links[number][level - 1].faces)
            # Normals of its own: those of an engraved letter would shade all of a flat cap that is left of it.
            known[level] = polydata(coarse.vertices, coarse.vertex_normals, coarse.faces)
        if self.shown[row] != level:
            actor.mapper.SetInputDataObject(known[level])
            self.shown[row] = level

    def fade(self, share: float) -> None:
        """Let so much of them go, 0 to 1, while the skin is flattened; stand-ins stay."""
        for actor in self._bodies:
            actor.prop.opacity = 1.0 - share
            actor.prop.culling = "back" if share > 0 or actor in self._solids else "none"  # a shadow has no inside

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        for actor in self._bodies:
            actor.prop.color = theme.body
        for actor in self._placeholders:  # they look like nothing of the robot: edges in the colour of warnings
            actor.prop.style = "wireframe"
            actor.prop.line_width = 2.0
            actor.prop.color = theme.warning
            actor.prop.lighting = False
