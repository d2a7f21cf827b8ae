"""Layers of View > Overlay on the body, one class each."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import PressureScale
from tactile_widgets.views.robot.actors.contact_marks import MAX_CONTACTS
from tactile_widgets.views.robot.actors.robot_actors import BodyLayer, RobotActors
from tactile_widgets.views.robot.actors.surface_marks import TaxelMarkers, add_mark, set_matrix

SHAPE_INK = "#5b6570"
"""Colour of ellipses and error circles on the skin, which is light in both themes."""
SMALLEST_ERROR = 0.001
"""Radius below which the mark of the centre hides the error circle [m]."""


class ContactShapes(BodyLayer):
    """Each contact's ellipse, dashed, and the error circle of its centre, dotted.

    A fixed set of actors, placed and shown as needed.
    """

    def __init__(self, actors: RobotActors) -> None:
        super().__init__(actors)
        self._index = actors.prepared.robot.link_index
        self.ellipses, self.errors = (
            [add_mark(actors.plotter, circle, SHAPE_INK, line_width=1.0) for _ in range(MAX_CONTACTS)]
            for circle in (_dashed_circle(every=2), _dashed_circle(every=1))
        )

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        """Draw the shape of each region that has one."""
        self.hide()
        if self.shown:
            for number, region in enumerate(frame.regions[:MAX_CONTACTS]):
                self._place(number, region, poses[self._index[region.link]])

    def set_shown(self, *, shown: bool) -> None:
        """Draw shapes from the next frame on, or hide them."""
        super().set_shown(shown=shown)
        if not shown:
            self.hide()

    def hide(self) -> None:
        """Hide all shapes."""
        for actor in (*self.ellipses, *self.errors):
            actor.visibility = False

    def _place(self, number: int, region: ContactRegion, pose: FloatArray) -> None:
        """Place ellipse and error circle of a region whose link has this ``T_world_link`` (4, 4)."""
        point = pose[:3, :3] @ region.link_position + pose[:3, 3]
        normal = pose[:3, :3] @ region.link_normal
        axes = region.link_axes @ pose[:3, :3].T
        lengths = np.linalg.norm(axes, axis=1)
        if not lengths.min() > 0:
            return
        circle = axes / lengths[:, None] * region.place_error
        for actor, own, least in ((self.ellipses[number], axes, 0.0), (self.errors[number], circle, SMALLEST_ERROR)):
            actor.visibility = bool(np.linalg.norm(own[0]) > least)
            if actor.visibility:
                matrix = np.eye(4)
                matrix[:3, 0] = own[0]
                matrix[:3, 1] = own[1]
                matrix[:3, 2] = normal
                matrix[:3, 3] = point + 0.0015 * normal
                set_matrix(actor, matrix)


def _dashed_circle(*, every: int) -> pv.PolyData:
    """Make a dashed unit circle with this number of its 72 sides in each dash."""
    turn = np.linspace(0, 2 * np.pi, 73)[:-1]
    points = np.stack([np.cos(turn), np.sin(turn), np.zeros(72)], axis=1)
    starts = np.arange(0, 72, every + 1)
    lines = [np.append(every + 1, (start + np.arange(every + 1)) % 72) for start in starts]
    return pv.PolyData(points, lines=np.concatenate(lines))


DOT_SIZE = 0.4
"""Radius of a taxel's dot, as a fraction of the square root of its area."""


class TaxelDiscs(BodyLayer):
    """Discs on all taxels, which follow the skin when it is flattened."""

    replaces_image = True

    def __init__(self, actors: RobotActors) -> None:
        super().__init__(actors)
        skin = actors.prepared.skin
        self._dots = TaxelMarkers(actors.plotter, skin, filled=True)
        self._every = np.arange(len(skin))
        actors.skin.carry(self._dots)

    def set_shown(self, *, shown: bool) -> None:
        """Show or hide the discs."""
        super().set_shown(shown=shown)
        taxels = self._every if shown else self._every[:0]
        self._dots.show(taxels, np.zeros((len(taxels), 3), np.uint8), radius=DOT_SIZE)

    def colour(self, pressures: FloatArray, scale: PressureScale) -> None:
        """Set the colours of the pressures (taxels,) [Pa]."""
        if self.shown:
            self._dots.colour(self._every, scale.rgb(1e-3 * pressures))
