"""Actors of a skin that is being chosen: its surface and taxels on the links."""

from __future__ import annotations

from typing import Any

import pyvista as pv

from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.views.robot.actors.surface_marks import add_mark, add_surface, polydata

_POINT_PX = 5
_LIFT = 1e-3
"""Height of the points above the surface [m], so that its curvature hides none."""
_TINT = 0.25
"""Share of the accent in the colour of the surface."""


class SkinPreviewActors:
    """A surface, and a point for each taxel, for each patch of the skin.

    Args:
        plotter: Plotter that draws them.
        robot: The robot.
        skin: The skin.
        theme: Colours.

    Attributes:
        link_actors: Link number and actor of each.
    """

    def __init__(self, plotter: Any, robot: Robot, skin: Skin, theme: Theme) -> None:
        self._plotter = plotter
        self._surfaces: list[Any] = []
        self._points: list[Any] = []
        self.link_actors: list[tuple[int, Any]] = []
        for patch in skin.patches:
            mesh = patch.surface
            surface = add_surface(plotter, polydata(mesh.vertices, mesh.vertex_normals, mesh.faces), theme.body)
            taxels = patch.taxels
            points = add_mark(plotter, pv.PolyData(taxels.positions + _LIFT * taxels.normals), theme.accent)
            points.prop.point_size = _POINT_PX
            points.visibility = True
            self._surfaces.append(surface)
            self._points.append(points)
            link = robot.link_index[patch.link]
            self.link_actors += [(link, surface), (link, points)]
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        for surface in self._surfaces:
            surface.prop.color = mixed(theme.body, theme.accent, _TINT)
        for points in self._points:
            points.prop.color = theme.accent

    def remove(self) -> None:
        """Remove the actors from the plotter."""
        for _, actor in self.link_actors:
            self._plotter.remove_actor(actor, render=False)
