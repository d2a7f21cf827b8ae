"""The scene's objects as actors in a colour and a gloss of their own, built once a scene, moved in place by frames.

With the grids of planes, and of the floor under the robot: as large as what stands on it needs.
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
from tactile_widgets.views.robot.scene.surface_marks import add_surface, polydata, set_matrix

_PROBE_OPACITY = 0.55
"""A probe looks as the finger does, but for this: nothing else shows where it is while it touches nothing."""
_PLANE_OPACITY = 0.5
_LEVEL = 0.9
"""Cosine of the tilt up to which a plane is a floor."""
_GLOSSY = {"specular": 0.25, "specular_power": 24}
"""Objects shine a little, as neither links nor skin do."""


class ObjectActors:
    """What is in the scene beside the robot. Without objects it keeps and draws nothing.

    A probe is tinted as the finger is, a plane is a thin plate with a grid, everything else is a body that cannot be
    taken for the robot.

    Args:
        plotter: Where to draw.
        theme: Neutral colours.
        bodies: The scene's, in the order of ``Frame.objects``.
    """

    def __init__(self, plotter: Any, theme: Theme, bodies: Sequence[SceneObject]) -> None:
        self._bodies = tuple(bodies)
        self._solids = [_add_solid(plotter, theme, body) for body in self._bodies]
        self._grids = {
            number: plotter.add_mesh(
                plane_grid(body.mesh.bounds),
                line_width=1, lighting=False, pickable=False, reset_camera=False,
            )
            for number, body in enumerate(self._bodies)
            if body.spec.kind == "plane"
        }  # fmt: skip
        self.poses = np.array([body.spec.pose.matrix for body in self._bodies]).reshape(-1, 4, 4)
        """(k, 4, 4) ``T_world_object`` as drawn."""
        self.set_theme(theme)
        self.move(self.poses)

    @property
    def actors(self) -> list[tuple[int, Any]]:
        """Object number and actor of all that is drawn."""
        return [*enumerate(self._solids), *self._grids.items()]

    @property
    def has_floor(self) -> bool:
        """Whether the scene brings a level plane of its own, so that no other floor is needed."""
        return any(abs(self._bodies[number].spec.pose.rotation[2, 2]) > _LEVEL for number in self._grids)

    def move(self, poses: FloatArray) -> None:
        """Put them where (k, 4, 4) ``T_world_object`` says, in place."""
        self.poses = poses
        for number, (actor, pose) in enumerate(zip(self._solids, poses, strict=True)):
            set_matrix(actor, pose)
            if number in self._grids:
                set_matrix(self._grids[number], pose)

    def fade(self, share: float) -> None:
        """Let so much of them go, 0 to 1, while the skin is flattened."""
        for body, actor in zip(self._bodies, self._solids, strict=True):
            actor.prop.opacity = (1.0 - share) * _opacity(body)
        for grid in self._grids.values():
            grid.prop.opacity = 1.0 - share

    def near(self, points: FloatArray, hidden: AbstractSet[int] = frozenset()) -> FloatArray:
        """(c, 3) corners [m], world, of the objects that belong into a picture of ``points`` (k, 3).

        Those no farther from their box than half its diagonal, and no larger than it; never a plane, which goes on,
        and none of the ``hidden`` numbers.
        """
        low = points.min(axis=0)
        high = points.max(axis=0)
        reach = 0.5 * float(np.linalg.norm(high - low))
        kept = [np.zeros((0, 3))]
        for number, (body, pose) in enumerate(zip(self._bodies, self.poses, strict=True)):
            if number in hidden:
                continue
            box = np.array(np.meshgrid(*body.mesh.bounds.T)).reshape(3, -1).T @ pose[:3, :3].T + pose[:3, 3]
            beside = (box.min(axis=0) < high + reach).all() and (box.max(axis=0) > low - reach).all()
            if beside and body.spec.kind != "plane" and np.linalg.norm(np.ptp(box, axis=0)) < 2 * reach:
                kept.append(box)
        return np.concatenate(kept)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
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
"""No floor is drawn wider [m]."""


def floor_grid(points: FloatArray) -> pv.PolyData:
    """A grid under points (k, 3) [m], world: at zero, or below the lowest of them."""
    span = float(np.clip(np.ptp(points[:, :2], axis=0).max(), 0.2, _MAX_WIDTH))
    step = _step(span)
    half = step * np.ceil(0.9 * span / step)
    centre = np.round(points[:, :2].mean(axis=0) / step) * step
    floor = min(float(points[:, 2].min()), 0.0) if points[:, 2].min() < -1e-3 else 0.0
    return _grid((half, half), step, np.array([*centre, floor]))


def plane_grid(bounds: FloatArray) -> pv.PolyData:
    """A grid over a plane within (2, 3) ``bounds`` [m] around its frame's origin, and lines along its edges."""
    x, y = (float(half) for half in bounds[1, :2])
    return _grid((x, y), _step(max(x, y)), np.zeros(3))


def _step(span: float) -> float:
    return float(10.0 ** np.floor(np.log10(span / 2)))


def _grid(half: tuple[float, float], step: float, centre: FloatArray) -> pv.PolyData:
    """Lines ``step`` apart from the middle out, and along the edges."""
    across, along = (_ticks(reach, step) for reach in half)
    ends = [[[t, -half[1]], [t, half[1]]] for t in across] + [[[-half[0], t], [half[0], t]] for t in along]
    lines = np.zeros((2 * len(ends), 3))
    lines[:, :2] = np.array(ends).reshape(-1, 2)
    pairs = np.insert(np.arange(len(lines)).reshape(-1, 2), 0, 2, axis=1)
    return pv.PolyData(lines + centre, lines=pairs.ravel())


def _ticks(reach: float, step: float) -> FloatArray:
    inner = step * np.arange(-np.floor(reach / step), np.floor(reach / step) + 1)
    return np.unique(np.round(np.concatenate([[-reach], inner, [reach]]), 9))
