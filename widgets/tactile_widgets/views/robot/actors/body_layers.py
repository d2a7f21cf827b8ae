"""Layers of View > Overlay on the body, one class each."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.detection.shear_estimation import TAXEL_SLIPS
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.raycast import ray_caster
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import PressureScale
from tactile_widgets.views.overlays.friction_marks import frame_friction, friction_legend, friction_rgb
from tactile_widgets.views.overlays.legend import MarkLegend
from tactile_widgets.views.overlays.shear_arrows import (
    ARROW_PX,
    TaxelGroups,
    arrow_ends,
    full_arrow,
    shear_legend,
    sheared_taxels,
)
from tactile_widgets.views.robot.actors.camera import Viewpoint
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


class BodyShear(BodyLayer):
    """Arrows of the traction on pressed taxels that face the camera, while frames have shear; see ``shear_arrows``.

    They are painted over the picture, so that an object that presses the skin does not hide them. A link of the robot
    in front of an arrow does.
    """

    def __init__(self, actors: RobotActors) -> None:
        super().__init__(actors)
        skin = actors.prepared.skin
        index = actors.prepared.robot.link_index
        self._links = np.array([index[patch.link] for patch in skin.patches], dtype=np.int64)[skin.patch_of]
        self._positions = skin.positions
        self._meshes = [(index[patch.link], patch.surface) for patch in skin.patches]
        links = enumerate(link.mesh for link in actors.prepared.robot.links)
        self._meshes += [(number, mesh) for number, mesh in links if mesh is not None and len(mesh.faces)]
        self._frame: Frame | None = None
        self._poses = np.zeros((0, 4, 4))

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        self._frame = None if frame.shear is None else frame
        self._poses = poses

    def hide(self) -> None:
        self._frame = None

    @property
    def legend(self) -> MarkLegend | None:
        return None if self._frame is None else shear_legend(self.actors.scale, self._frame.units)

    def arrows(self, viewpoint: Viewpoint, size: tuple[int, int]) -> FloatArray:
        frame = self._frame
        if frame is None or frame.shear is None:
            return np.zeros((0, 2, 2))
        map_ = self.actors.prepared.map
        taxels = sheared_taxels(frame)
        taxels = taxels[~np.isin(self._links[taxels], list(self.actors.hidden))]
        poses = self._poses[self._links[taxels]]
        places = np.einsum("kij,kj->ki", poses[:, :3, :3], self._positions[taxels]) + poses[:, :3, 3]
        axes = taxel_frames(map_)[taxels] @ np.swapaxes(poses[:, :3, :3], 1, 2)
        facing = (np.einsum("ki,ki->k", axes[:, 2], viewpoint.eye - places) > 0) & viewpoint.in_front(places)
        taxels = taxels[facing]
        places = places[facing]
        axes = axes[facing]
        pixel = _pixel_sizes(viewpoint, places, size)
        patches = map_.skin.patch_of[taxels]
        groups = TaxelGroups.of(
            map_.taxel_points[taxels], patches, map_.skin.areas[taxels], _cells(patches, ARROW_PX * pixel)
        )
        traction = np.einsum("kij,ki->kj", axes[:, :2], frame.shear[taxels])
        half = 0.5 * groups.means(traction * (ARROW_PX / full_arrow(self.actors.scale) * pixel)[:, None])
        middle = groups.means(places)
        seen = ~self._covered(middle, viewpoint.eye)
        half = half[seen]
        middle = middle[seen]
        ends = np.stack([viewpoint.pixels(middle + side * half, size) for side in (-1, 1)], axis=1)
        return arrow_ends(ends.mean(axis=1), ends[:, 1] - ends[:, 0])

    def _covered(self, points: FloatArray, eye: FloatArray) -> BoolArray:
        """(k,) whether a shown link is between points (k, 3) [m] and the eye. Cost: 10 µs per point and mesh."""
        covered = np.zeros(len(points), dtype=bool)
        meshes = [(number, ray_caster(mesh)) for number, mesh in self._meshes if number not in self.actors.hidden]
        for number, caster in meshes:
            pose = self._poses[number]
            origin = (eye - pose[:3, 3]) @ pose[:3, :3]
            for k in np.flatnonzero(~covered):
                step = (points[k] - pose[:3, 3]) @ pose[:3, :3] - origin
                distance = float(np.linalg.norm(step))
                hit = caster.first_hit(origin, step / distance)
                covered[k] = hit is not None and hit.distance < distance - _SKIN
        return covered


_SKIN = 5e-3
"""Distance up to which a surface in front of an arrow is the skin around it [m]."""


class FrictionDiscs(BodyLayer):
    """Discs in the colour of the friction in use on pressed taxels, with a ring around those that slip."""

    def __init__(self, actors: RobotActors) -> None:
        super().__init__(actors)
        skin = actors.prepared.skin
        self._discs = TaxelMarkers(actors.plotter, skin, filled=True)
        self._rings = TaxelMarkers(actors.plotter, skin)
        self._has_shear = False

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        used = frame_friction(frame) if self.shown else None
        self._has_shear = used is not None
        if used is None:
            self.hide()
            return
        touched = np.flatnonzero(np.isfinite(used))
        self._discs.show(touched, friction_rgb(used[touched]), radius=DOT_SIZE)
        slips = touched[used[touched] >= TAXEL_SLIPS]
        self._rings.show(slips, np.full((len(slips), 3), 255, np.uint8), radius=SLIP_SIZE)

    def set_shown(self, *, shown: bool) -> None:
        super().set_shown(shown=shown)
        if not shown:
            self.hide()

    def hide(self) -> None:
        for markers in (self._discs, self._rings):
            markers.show(np.zeros(0, np.int64), np.zeros((0, 3), np.uint8), radius=DOT_SIZE)

    @property
    def legend(self) -> MarkLegend | None:
        return friction_legend() if self._has_shear else None


def _pixel_sizes(viewpoint: Viewpoint, points: FloatArray, size: tuple[int, int]) -> FloatArray:
    """(k,) size of a pixel at points (k, 3) [m] in a picture of this size."""
    depth = (points - viewpoint.eye) @ viewpoint.axes[2]
    return np.asarray(2 * depth * np.tan(np.radians(viewpoint.view_angle) / 2) / max(size[1], 1))


def _cells(patches: IntArray, sides: FloatArray) -> FloatArray:
    """(k,) side of the cells of the patch of each taxel [m]: mean of ``sides``, rounded up in steps."""
    _, patch = np.unique(patches, return_inverse=True)
    means = np.bincount(patch, sides) / np.maximum(np.bincount(patch), 1)
    return np.asarray(2.0 ** (np.ceil(2 * np.log2(means)) / 2))[patch]


def _dashed_circle(*, every: int) -> pv.PolyData:
    """Make a dashed unit circle with this number of its 72 sides in each dash."""
    turn = np.linspace(0, 2 * np.pi, 73)[:-1]
    points = np.stack([np.cos(turn), np.sin(turn), np.zeros(72)], axis=1)
    starts = np.arange(0, 72, every + 1)
    lines = [np.append(every + 1, (start + np.arange(every + 1)) % 72) for start in starts]
    return pv.PolyData(points, lines=np.concatenate(lines))


DOT_SIZE = 0.4
SLIP_SIZE = 0.5
"""Radius of a taxel's dot, and of the ring around one that slips, as fractions of the square root of its area."""


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
