"""Marks on the body: centres of pressure with force arrows, fingertips, and the location under the pointer."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pyvista as pv

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.robot.actors.surface_marks import add_mark, set_matrix

ARROW_LENGTH = 0.012
"""Length of an arrow [m/N]."""
MAX_ARROW = 0.25
"""Longest arrow [m]."""
_RELATIVE_ARROW = 0.15
"""Length of the strongest contact's arrow where forces are unknown, as a share of the size of the largest patch."""
MAX_CONTACTS = 8
_SMALLEST_RING = 0.008
_RING_GAP = 0.003
_FINGER_OPACITY = 0.23
"""Opacity of a fingertip's near half, so that the touch below is visible; the far half is not drawn."""


def ring_radius(region: ContactRegion) -> float:
    """Return the radius of the ring around a region's touched skin [m]."""
    return max(1.35 * float(np.sqrt(region.area / np.pi)) + _RING_GAP, _SMALLEST_RING)


def arrow_legend(units: ReadingUnits) -> str:
    """Return the caption that explains the length of arrows."""
    if units.force is None:
        return "Arrow: relative to the strongest"
    return f"Arrow: {1e3 * ARROW_LENGTH:g}\u202fmm per newton"


@cache
def _mark_shapes() -> tuple[pv.PolyData, pv.PolyData, pv.PolyData, pv.PolyData]:
    """Rings of a contact and under the pointer, finger and arrow, of size 1; shared by all views, never changed."""
    return (
        pv.Disc(inner=0.93, outer=1.0, c_res=64),  # a ring, so that the touch inside stays visible
        pv.Disc(inner=0.62, outer=1.0, c_res=48),
        pv.Sphere(theta_resolution=24, phi_resolution=16),
        pv.Arrow(start=(0, 0, 1), direction=(0, 0, -1), tip_length=0.2, tip_radius=0.04, shaft_radius=0.013),
    )


class ContactMarks:
    """Fixed set of small actors, placed and shown as needed: no tick creates any.

    Args:
        plotter: Plotter that draws them.
        theme: Colours of the marks.
        prepared: Robot and skin.

    Attributes:
        forces: Tail and tip of each arrow, (2, 3) [m], world, and the region whose force it shows.
    """

    def __init__(self, plotter: Any, theme: Theme, prepared: PreparedScene) -> None:
        self._index = prepared.robot.link_index
        self._relative = _RELATIVE_ARROW * max(patch.surface.size for patch in prepared.skin.patches)
        disc, hover, ball, arrow = _mark_shapes()
        self._discs = [add_mark(plotter, disc, theme.accent) for _ in range(MAX_CONTACTS)]
        self._arrows = [add_mark(plotter, arrow, theme.accent) for _ in range(MAX_CONTACTS)]
        faint: dict[str, Any] = {"lit": True, "opacity": _FINGER_OPACITY}
        self._balls = [add_mark(plotter, ball, theme.text, **faint) for _ in range(MAX_CONTACTS)]
        for actor in self._balls:
            actor.prop.culling = "back"  # blending takes longer than drawing the robot
        self._hover = add_mark(plotter, hover, theme.accent)
        self.forces: list[tuple[FloatArray, ContactRegion]] = []

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        """Place discs and arrows at the regions' centres of pressure, and a ball at each fingertip."""
        regions = frame.regions[:MAX_CONTACTS]
        pokes = frame.pokes[:MAX_CONTACTS]
        strongest = max((region.force for region in regions), default=0.0)
        known = frame.units.force is not None
        scale = ARROW_LENGTH if known else self._relative / strongest if strongest > 0 else 0.0
        self.forces = []
        unused = (*self._discs[len(regions) :], *self._arrows[len(regions) :], *self._balls[len(pokes) :])
        for actor in unused:
            actor.visibility = False
        for region, disc, arrow in zip(regions, self._discs, self._arrows, strict=False):
            pose = poses[self._index[region.link]]
            point = pose[:3, :3] @ region.link_position + pose[:3, 3]
            normal = pose[:3, :3] @ region.link_normal
            ring = ring_radius(region)
            _place(disc, point + 0.001 * normal, normal, ring, ring)
            length = min(scale * region.force, MAX_ARROW)
            _place(arrow, point + 0.002 * normal, normal, 0.08, max(length, 1e-3))
            self.forces.append((point + np.outer([0.002 + length, 0.002], normal), region))
        for poke, ball in zip(pokes, self._balls, strict=False):
            size = 2 * poke.radius
            _place(ball, poke.world_position + poke.radius * poke.world_normal, poke.world_normal, size, size)

    def hide(self) -> None:
        """Hide contacts and fingers."""
        self.forces = []
        for actor in (*self._discs, *self._arrows, *self._balls):
            actor.visibility = False

    def set_hover(self, where: tuple[FloatArray, FloatArray] | None) -> None:
        """Draw a ring at the location under the pointer: position (3,) [m] and unit normal (3,), world frame."""
        if where is None:
            self._hover.visibility = False
        else:
            point, normal = where
            _place(self._hover, point + 0.0015 * normal, normal, 0.006, 0.006)

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        for ball in self._balls:
            ball.prop.color = theme.text


def _place(actor: Any, point: FloatArray, normal: FloatArray, width: float, length: float) -> None:
    """Show an actor at ``point`` with its z axis along ``normal``, scaled across and along it."""
    a, b, c = normal.tolist()
    least = min(abs(a), abs(b), abs(c))  # x is perpendicular to the axis that the normal is farthest from
    x = np.array([0.0, -c, b] if least == abs(a) else [c, 0.0, -a] if least == abs(b) else [-b, a, 0.0])
    x /= np.sqrt(x @ x)
    d, e, f = x.tolist()
    matrix = np.eye(4)
    matrix[:3, 0] = width * x
    matrix[:3, 2] = length * normal
    matrix[:3, 3] = point
    matrix[:3, 1] = width * (b * f - c * e), width * (c * d - a * f), width * (a * e - b * d)
    set_matrix(actor, matrix)
    actor.visibility = True
