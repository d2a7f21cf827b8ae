"""Actors of the scene's objects, with their own colour and gloss, and grids of planes and of the floor.

They are built once per scene and moved in place.
"""

from __future__ import annotations

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np
import pyvista as pv

from tactile_maps.core.arrays import FloatArray
from tactile_maps.scene.objects import SceneObject
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.views.robot.actors.camera import box_corners
from tactile_widgets.views.robot.actors.surface_marks import add_surface, polydata, set_matrix

_PROBE_OPACITY = 0.55
"""A probe is less transparent than a fingertip, because nothing else marks it while it touches nothing."""
_PLANE_OPACITY = 0.5
_LEVEL = 0.9
"""Cosine of the maximum tilt of a floor."""
_GLOSSY = {"specular": 0.25, "specular_power": 24}
"""Gloss that distinguishes objects from links and skin."""


class ObjectActors:
    """Actors of the scene's objects.

    A probe has the colour of a fingertip, a plane is a thin plate with a grid, and other objects differ from the robot
    in colour.

    Args:
        plotter: Plotter that draws them.
        theme: Neutral colours.
        bodies: Objects of the scene, in the order of ``Frame.objects``.
    """

    def __init__(self, plotter: Any, theme: Theme, bodies: Sequence[SceneObject]) -> None:
        self._bodies = tuple(bodies)
        self._solids = [_add_solid(plotter, theme, body) for body in self._bodies]
        self._grids = {
            number: plotter.add_mesh(
                plane_grid(body.mesh.bounds),
                line_width=1,
                lighting=False,
                pickable=False,
                reset_camera=False,
            )
            for number, body in enumerate(self._bodies)
            if body.spec.kind == "plane"
        }
        self.poses = np.array([body.spec.pose.matrix for body in self._bodies]).reshape(-1, 4, 4)
        """(k, 4, 4) ``T_world_object`` as drawn."""
        self.set_theme(theme)
        self.move(self.poses)

    @property
    def actors(self) -> list[tuple[int, Any]]:
        """Object number and actor of everything drawn."""
        return [*enumerate(self._solids), *self._grids.items()]

    @property
    def has_floor(self) -> bool:
        """Whether the scene has a level plane, which replaces the floor grid."""
        return any(abs(self._bodies[number].spec.pose.rotation[2, 2]) > _LEVEL for number in self._grids)

    def move(self, poses: FloatArray) -> None:
        """Move the objects in place to (k, 4, 4) ``T_world_object``."""
        self.poses = poses
        for number, (actor, pose) in enumerate(zip(self._solids, poses, strict=True)):
            set_matrix(actor, pose)
            if number in self._grids:
                set_matrix(self._grids[number], pose)

    def fade(self, share: float) -> None:
        """Fade the objects by this amount, 0 to 1, while the skin is flattened."""
        for body, actor in zip(self._bodies, self._solids, strict=True):
            actor.prop.opacity = (1.0 - share) * _opacity(body)
        for grid in self._grids.values():
            grid.prop.opacity = 1.0 - share

    def near(self, points: FloatArray, hidden: AbstractSet[int] = frozenset()) -> FloatArray:
        """(c, 3) corners [m], world, of the objects that belong into a picture of ``points`` (k, 3).

        These are objects no farther from the points' box than half its diagonal and no larger than it, except planes,
        which extend beyond any picture, and the ``hidden`` ones.
        """
        low = points.min(axis=0)
        high = points.max(axis=0)
        reach = 0.5 * float(np.linalg.norm(high - low))
        kept = [np.zeros((0, 3))]
        for number, (body, pose) in enumerate(zip(self._bodies, self.poses, strict=True)):
            if number in hidden or body.spec.kind == "plane":
                continue
            box = box_corners(body.mesh.bounds, pose)
            is_near = (box.min(axis=0) < high + reach).all() and (box.max(axis=0) > low - reach).all()
            if is_near and np.linalg.norm(np.ptp(box, axis=0)) < 2 * reach:
                kept.append(box)
        return np.concatenate(kept)

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        for body, actor in zip(self._bodies, self._solids, strict=True):
            actor.prop.color = _colour(body, theme)
        for grid in self._grids.values():
            grid.prop.color = mixed(theme.window, theme.quiet, 0.45)


def _add_solid(plotter: Any, theme: Theme, body: SceneObject) -> Any:
    smooth = body.spec.kind in ("probe", "sphere", "mesh")
    look: dict[str, Any] = _GLOSSY | {"interpolation": "Phong" if smooth else "Flat"}
    if body.spec.kind == "plane":
        look = {"interpolation": "Flat", "lighting": False, "ambient": 0.0, "diffuse": 1.0}
    surface = polydata(body.mesh.vertices, body.mesh.vertex_normals, body.mesh.faces)
    return add_surface(plotter, surface, _colour(body, theme), opacity=_opacity(body), pickable=False, **look)


def _opacity(body: SceneObject) -> float:
    return {"probe": _PROBE_OPACITY, "plane": _PLANE_OPACITY}.get(body.spec.kind, 1.0)


def _colour(body: SceneObject, theme: Theme) -> str:
    if body.spec.kind == "probe":
        return theme.text
    if body.spec.kind == "plane":
        return mixed(theme.window, theme.quiet, 0.16)
    return theme.thing


_MAX_WIDTH = 20.0
"""Maximum width of the floor [m]."""


def floor_grid(points: FloatArray) -> pv.PolyData:
    """Make a grid under points (k, 3) [m], world: at zero, or below the lowest point."""
    span = float(np.clip(np.ptp(points[:, :2], axis=0).max(), 0.2, _MAX_WIDTH))
    step = _step(span)
    half = step * np.ceil(0.9 * span / step)
    centre = np.round(points[:, :2].mean(axis=0) / step) * step
    floor = min(float(points[:, 2].min()), 0.0) if points[:, 2].min() < -1e-3 else 0.0
    return _grid((half, half), step, np.array([*centre, floor]))


def plane_grid(bounds: FloatArray) -> pv.PolyData:
    """Make a grid over a plane within (2, 3) ``bounds`` [m] around its frame's origin, with lines along its edges."""
    x, y = (float(half) for half in bounds[1, :2])
    return _grid((x, y), _step(max(x, y)), np.zeros(3))


def _step(span: float) -> float:
    return float(10.0 ** np.floor(np.log10(span / 2)))


def _grid(half: tuple[float, float], step: float, centre: FloatArray) -> pv.PolyData:
    """Make lines ``step`` apart, starting from the centre, and along the edges."""
    across, along = (_ticks(reach, step) for reach in half)
    ends = [[[t, -half[1]], [t, half[1]]] for t in across] + [[[-half[0], t], [half[0], t]] for t in along]
    lines = np.zeros((2 * len(ends), 3))
    lines[:, :2] = np.array(ends).reshape(-1, 2)
    pairs = np.insert(np.arange(len(lines)).reshape(-1, 2), 0, 2, axis=1)
    return pv.PolyData(lines + centre, lines=pairs.ravel())


def _ticks(reach: float, step: float) -> FloatArray:
    inner = step * np.arange(-np.floor(reach / step), np.floor(reach / step) + 1)
    return np.unique(np.round(np.concatenate([[-reach], inner, [reach]]), 9))
