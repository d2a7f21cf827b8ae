"""A law's task on the body: the wanted path as a violet ribbon, the target's ring, the way of the contact in white."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pyvista as pv

from app.arrays import FloatArray
from app.geometry.surface_point import SurfacePoint
from app.session.prepare import Prepared
from widgets.colours import Theme
from widgets.robot_view.flat_shapes import Piece, add, fill, nothing
from widgets.robot_view.link_marks import LinkMarks
from widgets.robot_view.ribbons import heads, quads, ribbon
from widgets.robot_view.taxel_rings import axes_across
from widgets.task_shown import NO_TASK, SkinLine, Tail, TaskShown

_HALO, _RIM, _WHITE = "#ffffff", "#1d2126", "#ffffff"
_RING = 6.0
"""Radius of the target's ring, in widths of a line."""
_TURN = np.linspace(0, 2 * np.pi, 33)


class TaskMarks(LinkMarks):
    """Three actors a patch, in the frame of its link: path, way of the contact, target. Mutable.

    Args:
        plotter: Where to draw.
        theme: Its intent is the controller's colour.
        prepared: Whose skin is marked.

    Attributes:
        riders: Link number and actor of all that moves with a link.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: Prepared) -> None:
        super().__init__(theme, prepared)
        self._task, patches = NO_TASK, prepared.skin.patches
        self._kinds = {name: [_Flat(plotter) for _ in patches] for name in ("path", "tail", "target")}
        self._ride([flat.actor for flat in kind] for kind in self._kinds.values())

    def show(self, task: TaskShown) -> None:
        """Show this one. Cost: 1 ms for what has changed of it."""
        shown, self._task = self._task, task
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
    def _seen(self) -> TaskShown:
        return NO_TASK if self._hidden else self._task

    def _draw_path(self) -> None:
        for number, flat in enumerate(self._kinds["path"]):
            lines = [line for line in self._seen.path.lines if line.patch == number]
            flat.fill([piece for line in lines for piece in self._path(line)])

    def _path(self, line: SkinLine) -> Iterable[Piece]:
        width, places = self._width, (line.on_body, line.normals)
        yield ribbon(*places, 3.4 * width, lift=0.30 * width), _HALO
        yield ribbon(*places, 2.0 * width, lift=0.45 * width), self._theme.intent
        yield heads(*places, 6.5 * width, every=30 * width, lift=0.55 * width), self._theme.intent

    def _draw_tail(self) -> None:
        tail, flats = self._seen.tail, self._kinds["tail"]
        for number, flat in enumerate(flats):
            parts = [part for part in tail.lines if tail.patch[part.start] == number]
            flat.fill([piece for part in parts for piece in self._tail(tail, part)])

    def _tail(self, tail: Tail, part: slice) -> Iterable[Piece]:
        """It fades by growing thin: seen through, it would be mixed with the touch below."""
        places, width = (tail.on_body[part], tail.normals[part]), self._width
        fresh = 1 - tail.age[part]
        own = width * (0.3 + 0.8 * (fresh[1:] + fresh[:-1]))
        yield ribbon(*places, own + 1.2 * width, lift=0.7 * width), _RIM
        yield ribbon(*places, own, lift=0.85 * width), _WHITE

    def _draw_target(self) -> None:
        at = self._seen.target
        for number, flat in enumerate(self._kinds["target"]):
            flat.fill([] if at is None or at.patch != number else self._target(at))

    def _target(self, at: SurfacePoint) -> list[Piece]:
        """A ring with a cross hair that leaves its middle free."""
        point, normal, width = self._skin.position(at), self._skin.normal(at), self._width
        (x,), (y,) = axes_across(normal[None])
        return [
            (_cross_hair(point + lift * width * normal, x, y, _RING * width, wide * width), ink)
            for ink, wide, lift in ((_HALO, 2.8, 1.0), (self._theme.intent, 1.5, 1.15))
        ]


class _Flat:
    """One actor of flat shapes."""

    def __init__(self, plotter: Any) -> None:
        self._mesh: pv.PolyData = nothing()
        self.actor = add(plotter, self._mesh)

    def fill(self, pieces: list[Piece]) -> None:
        fill(self._mesh, self.actor, pieces)


def _cross_hair(middle: FloatArray, x: FloatArray, y: FloatArray, radius: float, wide: float) -> FloatArray:
    """(t, 3, 3) a ring of this radius with four strokes through it, all ``wide`` [m]."""
    turn = np.cos(_TURN)[:, None] * x + np.sin(_TURN)[:, None] * y
    inner, outer = (middle + (radius + side * wide / 2) * turn for side in (-1, 1))
    ring = quads(np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1))
    strokes = []
    for along, aside in ((x, y), (-x, y), (y, x), (-y, x)):
        near, far = middle + (0.5 * radius) * along, middle + (1.6 * radius + wide / 4) * along
        strokes.append(
            [near - wide / 2 * aside, far - wide / 2 * aside, far + wide / 2 * aside, near + wide / 2 * aside]
        )
    return np.concatenate([ring, quads(np.array(strokes))])
