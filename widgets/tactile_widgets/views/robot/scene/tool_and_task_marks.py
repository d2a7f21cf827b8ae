"""What an edit tool and the controller's task draw on the body, just above the skin.

Tools: lines, diamonds and tints. Task: the wanted path as a violet ribbon, the target's ring, the contact's path in
white.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pyvista as pv

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.body_overlays import (
    NO_MARKS,
    EdgeMark,
    MarkRole,
    PointMark,
    PolylineMark,
    ToolMarks,
    area_triangles,
)
from tactile_widgets.views.overlays.task_overlay import NO_TASK, ContactTrail, SkinPolyline, TaskOverlay
from tactile_widgets.views.robot.scene.surface_marks import (
    ColouredTriangles,
    SurfaceMarks,
    add_mark,
    arrowheads,
    diamonds,
    empty_mesh,
    fill_mesh,
    quads,
    ribbon,
    tangent_axes,
)

_OUTLINE = "#1d2126"
_TINT_OPACITY = 0.4
_SMALL = 2.6
_LARGE = 3.6
"""Half a diamond's diagonal, in widths of a line."""


class EditToolMarks(SurfaceMarks):
    """Two actors a patch, in the frame of its link: solid marks and tints. Mutable; ``show`` replaces all of them.

    Args:
        plotter: Where to draw.
        theme: Accents.
        prepared: Whose skin is marked.

    Attributes:
        link_actors: Link number and actor of all that moves with a link.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        super().__init__(theme, prepared)
        self._marks = NO_MARKS
        self._solids = [empty_mesh() for _ in prepared.skin.patches]
        self._tints = [empty_mesh() for _ in prepared.skin.patches]
        self._solid_actors = [add_mark(plotter, mesh) for mesh in self._solids]
        self._tint_actors = [add_mark(plotter, mesh, opacity=_TINT_OPACITY) for mesh in self._tints]
        self._attach_to_links((self._solid_actors, self._tint_actors))

    def show(self, marks: ToolMarks) -> None:
        """Show these and no others. Cost: 1 ms for a hundred edges; nothing for the same again."""
        if marks is not self._marks:
            self._marks = marks
            self._draw()

    def _draw(self) -> None:
        # While another scene is being shown, and in a replay, a tool may still be about the skin before.
        marks = NO_MARKS if self._hidden or self._marks.skin is not self._skin else self._marks
        for number, patch in enumerate(self._skin.patches):
            lines = [line for line in marks.lines if line.patch == number]
            spots = [spot for spot in marks.spots if spot.at.patch == number]
            tinted = [tint.vertices for tint in marks.tints if tint.patch == number]
            strokes = [stroke for stroke in marks.strokes if stroke.line.patch == number]
            pieces = [*self._lines(patch.surface, lines), *self._strokes(strokes), *self._spots(spots)]
            fill_mesh(self._solids[number], self._solid_actors[number], pieces)
            tints = [(self._tint(patch.surface, vertices), self._theme.accent) for vertices in tinted]
            fill_mesh(self._tints[number], self._tint_actors[number], tints)

    def _lines(self, surface: Mesh, lines: Sequence[EdgeMark]) -> list[ColouredTriangles]:
        return [
            piece
            for line in lines
            for piece in self._line(surface.vertices[line.vertices], surface.vertex_normals[line.vertices], line.role)
        ]

    def _strokes(self, strokes: Sequence[PolylineMark]) -> list[ColouredTriangles]:
        return [
            piece for stroke in strokes for piece in self._line(stroke.line.on_body, stroke.line.normals, stroke.role)
        ]

    def _line(self, points: FloatArray, normals: FloatArray, role: MarkRole) -> list[ColouredTriangles]:
        dash = 5.0 * self._width if role.dashed else 0.0
        top = ribbon(points, normals, self._width, lift=0.5 * self._width, dash=dash), self._ink(role)
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
        inks = [self._ink(spot.role) for spot in spots]
        return [(rims, _OUTLINE), *zip(tops.reshape(len(spots), -1, 3, 3), inks, strict=True)]

    def _tint(self, surface: Mesh, vertices: IntArray) -> FloatArray:
        """(t, 3, 3) the area around ``vertices``."""
        marked = np.zeros(len(surface.vertices), bool)
        marked[vertices] = True
        ends = area_triangles(surface.faces, marked)
        return (surface.vertices[ends] + 0.2 * self._width * surface.vertex_normals[ends]).mean(axis=2)

    def _ink(self, role: MarkRole) -> str:
        return role.ink(self._theme)


_HALO = "#ffffff"
_RIM = "#1d2126"
_WHITE = "#ffffff"
_RING = 6.0
"""Radius of the target's ring, in widths of a line."""
_CIRCLE_ANGLES = np.linspace(0, 2 * np.pi, 33)


class TaskMarks(SurfaceMarks):
    """Three actors a patch, in the frame of its link: path, way of the contact, target. Mutable.

    Args:
        plotter: Where to draw.
        theme: Its intent is the controller's colour.
        prepared: Whose skin is marked.

    Attributes:
        link_actors: Link number and actor of all that moves with a link.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        super().__init__(theme, prepared)
        self._task = NO_TASK
        patches = prepared.skin.patches
        self._kinds = {name: [_FlatActor(plotter) for _ in patches] for name in ("path", "tail", "target")}
        self._attach_to_links([flat.actor for flat in kind] for kind in self._kinds.values())

    def show(self, task: TaskOverlay) -> None:
        """Show this one. Cost: 1 ms for what has changed of it."""
        shown = self._task
        self._task = task
        if self._hidden:
            return
        if task.path is not shown.path:
            self._draw_path()
        if task.tail is not shown.tail:
            self._draw_tail()
        if task.target != shown.target:
            self._draw_target()

    def _draw(self) -> None:
        self._draw_path()
        self._draw_tail()
        self._draw_target()

    @property
    def _seen(self) -> TaskOverlay:
        return NO_TASK if self._hidden else self._task

    def _draw_path(self) -> None:
        for number, flat in enumerate(self._kinds["path"]):
            lines = [line for line in self._seen.path.lines if line.patch == number]
            flat.fill([piece for line in lines for piece in self._path(line)])

    def _path(self, line: SkinPolyline) -> Iterable[ColouredTriangles]:
        width = self._width
        places = (line.on_body, line.normals)
        yield ribbon(*places, 3.4 * width, lift=0.30 * width), _HALO
        yield ribbon(*places, 2.0 * width, lift=0.45 * width), self._theme.intent
        yield arrowheads(*places, 6.5 * width, every=30 * width, lift=0.55 * width), self._theme.intent

    def _draw_tail(self) -> None:
        tail = self._seen.tail
        flats = self._kinds["tail"]
        for number, flat in enumerate(flats):
            parts = [part for part in tail.lines if tail.patch[part.start] == number]
            flat.fill([piece for part in parts for piece in self._tail(tail, part)])

    def _tail(self, tail: ContactTrail, part: slice) -> Iterable[ColouredTriangles]:
        """It fades by growing thin: seen through, it would be mixed with the touch below."""
        places = (tail.on_body[part], tail.normals[part])
        width = self._width
        fresh = 1 - tail.age[part]
        own = width * (0.3 + 0.8 * (fresh[1:] + fresh[:-1]))
        yield ribbon(*places, own + 1.2 * width, lift=0.7 * width), _RIM
        yield ribbon(*places, own, lift=0.85 * width), _WHITE

    def _draw_target(self) -> None:
        at = self._seen.target
        for number, flat in enumerate(self._kinds["target"]):
            flat.fill([] if at is None or at.patch != number else self._target(at))

    def _target(self, at: SurfacePoint) -> list[ColouredTriangles]:
        """A ring with a cross hair that leaves its middle free."""
        point = self._skin.position(at)
        normal = self._skin.normal(at)
        width = self._width
        (x,), (y,) = tangent_axes(normal[None])
        return [
            (_cross_hair(point + lift * width * normal, x, y, _RING * width, wide * width), ink)
            for ink, wide, lift in ((_HALO, 2.8, 1.0), (self._theme.intent, 1.5, 1.15))
        ]


class _FlatActor:
    """One actor of flat shapes."""

    def __init__(self, plotter: Any) -> None:
        self._mesh: pv.PolyData = empty_mesh()
        self.actor = add_mark(plotter, self._mesh)

    def fill(self, pieces: list[ColouredTriangles]) -> None:
        fill_mesh(self._mesh, self.actor, pieces)


def _cross_hair(middle: FloatArray, x: FloatArray, y: FloatArray, radius: float, wide: float) -> FloatArray:
    """(t, 3, 3) a ring of this radius with four strokes through it, all ``wide`` [m]."""
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
