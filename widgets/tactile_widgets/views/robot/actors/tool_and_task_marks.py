"""Marks of the active tool and of the controller's task on the body, just above the skin.

Tools have lines, diamonds and tints; a task has its reference path as a violet ribbon, a ring around the target and the
contact path in white.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.body_overlays import (
    NO_MARKS,
    MarkRole,
    PointMark,
    ToolMarks,
    area_triangles,
)
from tactile_widgets.views.overlays.task_overlay import NO_TASK, ContactTrail, SkinPolyline, TaskOverlay
from tactile_widgets.views.robot.actors.surface_marks import (
    ColouredTriangles,
    SurfaceMarks,
    arrowheads,
    diamonds,
    quads,
    ribbon,
    tangent_axes,
)

_OUTLINE = "#1d2126"
_TINT_OPACITY = 0.4
_SMALL = 2.6
_LARGE = 3.6
"""Half the diagonal of a diamond, in line widths."""


class EditToolMarks(SurfaceMarks):
    """Marks of a tool: solid marks and tints; ``show`` replaces all of them.

    Args:
        plotter: Plotter that draws them.
        theme: Colours of the marks.
        prepared: Robot and skin.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        super().__init__(theme, prepared)
        self._marks = NO_MARKS
        self._solids = self._make_marks(plotter)
        self._tints = self._make_marks(plotter, opacity=_TINT_OPACITY)

    def show(self, marks: ToolMarks) -> None:
        """Show these marks only. Cost: 1 ms for a hundred edges; nothing for the same object."""
        if marks is not self._marks:
            self._marks = marks
            self._draw()

    def _draw(self) -> None:
        # While another scene is opened, and in a replay, a tool may still mark the previous skin.
        marks = NO_MARKS if self._hidden or self._marks.skin is not self._skin else self._marks
        for number, patch in enumerate(self._skin.patches):
            surface = patch.surface
            pieces: list[ColouredTriangles] = []
            for line in marks.lines:
                if line.patch == number:
                    ends = line.vertices
                    pieces += self._line(surface.vertices[ends], surface.vertex_normals[ends], line.role)
            for stroke in marks.strokes:
                if stroke.line.patch == number:
                    pieces += self._line(stroke.line.on_body, stroke.line.normals, stroke.role)
            pieces += self._spots([spot for spot in marks.spots if spot.at.patch == number])
            self._solids[number].fill(pieces)
            tints = [self._tint(surface, tint.vertices) for tint in marks.tints if tint.patch == number]
            self._tints[number].fill([(tint, self._theme.accent) for tint in tints])

    def _line(self, points: FloatArray, normals: FloatArray, role: MarkRole) -> list[ColouredTriangles]:
        dash = 5.0 * self._width if role.dashed else 0.0
        ink = role.ink(self._theme)
        top = ribbon(points, normals, self._width, lift=0.5 * self._width, dash=dash), ink
        if role is MarkRole.SEAM:
            return [top]
        return [(ribbon(points, normals, 2.0 * self._width, lift=0.35 * self._width), _OUTLINE), top]

    def _spots(self, spots: Sequence[PointMark]) -> list[ColouredTriangles]:
        if not spots:
            return []
        points = np.array([self._skin.position(spot.at) for spot in spots])
        normals = np.array([self._skin.normal(spot.at) for spot in spots])
        half = self._width * np.array([_LARGE if spot.large else _SMALL for spot in spots])
        rims = diamonds(points + 0.7 * self._width * normals, normals, half + 0.9 * self._width)
        tops = diamonds(points + 0.95 * self._width * normals, normals, half)
        inks = [spot.role.ink(self._theme) for spot in spots]
        return [(rims, _OUTLINE), *zip(tops.reshape(len(spots), -1, 3, 3), inks, strict=True)]

    def _tint(self, surface: Mesh, vertices: IntArray) -> FloatArray:
        """(t, 3, 3) triangles of the area around ``vertices``."""
        marked = np.zeros(len(surface.vertices), bool)
        marked[vertices] = True
        ends = area_triangles(surface.faces, marked)
        return (surface.vertices[ends] + 0.2 * self._width * surface.vertex_normals[ends]).mean(axis=2)


_HALO = "#ffffff"
_RIM = "#1d2126"
_WHITE = "#ffffff"
_RING = 6.0
"""Radius of the target's ring, in line widths."""
_CIRCLE_ANGLES = np.linspace(0, 2 * np.pi, 33)


class TaskMarks(SurfaceMarks):
    """Marks of a task: path, contact path and target.

    Args:
        plotter: Plotter that draws them.
        theme: Its intent is the controller's colour.
        prepared: Robot and skin.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        super().__init__(theme, prepared)
        self._task = NO_TASK
        self._kinds = {name: self._make_marks(plotter) for name in ("path", "tail", "target")}

    def show(self, task: TaskOverlay) -> None:
        """Show this task. Cost: 1 ms for each changed part."""
        shown = self._task
        self._task = task
        changed = {
            "path": task.path is not shown.path,
            "tail": task.tail is not shown.tail,
            "target": task.target != shown.target,
        }
        if not self._hidden:
            self._draw_kinds(kind for kind, other in changed.items() if other)

    def _draw(self) -> None:
        self._draw_kinds(self._kinds)

    def _draw_kinds(self, kinds: Iterable[str]) -> None:
        task = NO_TASK if self._hidden else self._task
        for kind in kinds:
            for number, marks in enumerate(self._kinds[kind]):
                marks.fill(list(self._pieces(kind, task, number)))

    def _pieces(self, kind: str, task: TaskOverlay, number: int) -> Iterable[ColouredTriangles]:
        """Triangles of one kind of mark on the patch of this number."""
        if kind == "path":
            for line in task.path.lines:
                if line.patch == number:
                    yield from self._path(line)
        elif kind == "tail":
            for part in task.tail.lines:
                if task.tail.patch[part.start] == number:
                    yield from self._tail(task.tail, part)
        elif task.target is not None and task.target.patch == number:
            yield from self._target(task.target)

    def _path(self, line: SkinPolyline) -> Iterable[ColouredTriangles]:
        width = self._width
        places = (line.on_body, line.normals)
        yield ribbon(*places, 3.4 * width, lift=0.30 * width), _HALO
        yield ribbon(*places, 2.0 * width, lift=0.45 * width), self._theme.intent
        yield arrowheads(*places, 6.5 * width, every=30 * width, lift=0.55 * width), self._theme.intent

    def _tail(self, tail: ContactTrail, part: slice) -> Iterable[ColouredTriangles]:
        """Fade by width: a translucent line would mix with the colours of the touch below."""
        places = (tail.on_body[part], tail.normals[part])
        width = self._width
        fresh = 1 - tail.age[part]
        own = width * (0.3 + 0.8 * (fresh[1:] + fresh[:-1]))
        yield ribbon(*places, own + 1.2 * width, lift=0.7 * width), _RIM
        yield ribbon(*places, own, lift=0.85 * width), _WHITE

    def _target(self, at: SurfacePoint) -> list[ColouredTriangles]:
        """Ring with a cross hair that leaves its centre free."""
        point = self._skin.position(at)
        normal = self._skin.normal(at)
        width = self._width
        (x,), (y,) = tangent_axes(normal[None])
        return [
            (_cross_hair(point + lift * width * normal, x, y, _RING * width, wide * width), ink)
            for ink, wide, lift in ((_HALO, 2.8, 1.0), (self._theme.intent, 1.5, 1.15))
        ]


def _cross_hair(middle: FloatArray, x: FloatArray, y: FloatArray, radius: float, wide: float) -> FloatArray:
    """(t, 3, 3) triangles of a ring of this radius with four strokes through it, all ``wide`` [m]."""
    turn = np.cos(_CIRCLE_ANGLES)[:, None] * x + np.sin(_CIRCLE_ANGLES)[:, None] * y
    inner, outer = (middle + (radius + side * wide / 2) * turn for side in (-1, 1))
    ring = quads(np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1))
    strokes = []
    for along, aside in ((x, y), (-x, y), (y, x), (-y, x)):
        near = middle + (0.5 * radius) * along
        far = middle + (1.6 * radius + wide / 4) * along
        strokes.append(
            [near - wide / 2 * aside, far - wide / 2 * aside, far + wide / 2 * aside, near + wide / 2 * aside]
        )
    return np.concatenate([ring, quads(np.array(strokes))])
