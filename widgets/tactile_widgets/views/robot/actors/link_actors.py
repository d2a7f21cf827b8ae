"""Actors of the bare links, with coarser surfaces where triangles are smaller than a pixel.

Only ``LinkActors`` selects the surface that is shown. Picking and measurements use the link's mesh.
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
from tactile_widgets.views.robot.actors.camera import Viewpoint
from tactile_widgets.views.robot.actors.surface_marks import add_surface, polydata

PIXELS = 0.5
"""Maximum error of a shown surface [px]."""
_BELOW = 1.0, 1.0
"""Factor of the slope and number of depth steps by which links are farther away, as for ``glPolygonOffset``."""


def _draw_below(actor: pv.Actor) -> None:
    """Draw a surface below those at the same place, in 1.2 times the time: each pixel states its own depth."""
    actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
    actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(*_BELOW)


class LinkActors:
    """Actors of all links with a mesh; ``set_levels`` and ``choose`` select its surface.

    Args:
        plotter: Plotter that draws them.
        robot: The robot.
        theme: Colours of the body, and of warnings for placeholders of missing meshes.
        below: Whether links are drawn below surfaces at the same place: the body of a skin without a robot is the
            skin itself.

    Attributes:
        placed: Link number and actor of each.
        shown: Level of each actor's surface: 0 for the link's own mesh, rising with the error.
    """

    def __init__(self, plotter: Any, robot: Robot, theme: Theme, *, below: bool = False) -> None:
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
                if below:
                    _draw_below(actor)
                self.placed.append((number, actor))
                self._surfaces.append({0: body})
                (self._placeholders if link.missing else self._bodies).append(actor)
                if link.mesh.is_solid:
                    self._solids |= {actor}
                    actor.prop.culling = "back"  # reduces the drawing time by a third
                balls.append([*link.mesh.bounds.mean(axis=0), 0.5 * link.mesh.size])
        self._balls = np.array(balls).reshape(-1, 4)  # around each link: centre in its frame, radius [m]
        self.shown = np.zeros(len(self.placed), int)
        self._levels: LinkLevels | None = None
        self._errors = np.zeros((len(self.placed), 1))
        self.set_theme(theme)

    def set_levels(self, levels: LinkLevels | None) -> None:
        """Use these coarser surfaces from the next ``choose`` on; those of another robot are ignored."""
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
        """Show the coarsest surface of each link whose error is below ``PIXELS`` at the link's closest point.

        Args:
            view: Viewpoint of the picture.
            height: Height of the picture [px].
            poses: (links, 4, 4) ``T_world_link``.

        Cost: 50 µs for 40 links; 1 ms for each change of a surface.
        """
        if self._levels is None:
            return
        own = poses[[number for number, _ in self.placed]]
        middles = np.einsum("nij,nj->ni", own[:, :3, :3], self._balls[:, :3]) + own[:, :3, 3]
        nearest = (middles - view.eye) @ view.axes[2] - self._balls[:, 3]
        pixel = 2 * np.maximum(nearest, 0.0) * np.tan(np.radians(view.view_angle) / 2) / max(height, 1.0)
        levels = (self._errors <= PIXELS * pixel[:, None]).sum(axis=1) - 1
        for row in np.flatnonzero(levels != self.shown):
            self._show(int(row), int(levels[row]))

    def _show(self, row: int, level: int) -> None:
        number, actor = self.placed[row]
        known = self._surfaces[row]
        mesh = self._robot.links[number].mesh
        if level not in known and self._levels is not None and mesh is not None:
            coarse, _ = coarse_mesh(mesh, self._levels.links[number][level - 1].faces)
            # Its own normals: those of an engraved letter would shade the whole flat cap that remains of it.
            known[level] = polydata(coarse.vertices, coarse.vertex_normals, coarse.faces)
        if self.shown[row] != level:
            actor.mapper.SetInputDataObject(known[level])
            self.shown[row] = level

    def fade(self, share: float) -> None:
        """Fade the links by this amount, 0 to 1, while the skin is flattened; placeholders stay."""
        for actor in self._bodies:
            actor.prop.opacity = 1.0 - share
            actor.prop.culling = (
                "back" if share > 0 or actor in self._solids else "none"
            )  # a translucent link must not show its inside

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        for actor in self._bodies:
            actor.prop.color = theme.body
        for actor in self._placeholders:  # unlike any part of the robot: edges in the colour of warnings
            actor.prop.style = "wireframe"
            actor.prop.line_width = 2.0
            actor.prop.color = theme.warning
            actor.prop.lighting = False
