"""Rerun log of a session: robot and taxels in 3-D, the tactile image, contacts and joints, tick by tick.

All entries are on the timeline ``time`` (simulated seconds). Points are coloured by pressure; joints and the force of
each contact are numbers over time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tactile_maps.core.arrays import length
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.pressure_colours import COLOURS, colour_image
from tactile_maps.recording.encoding.viewer_messages import frame_names, object_frame
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene

_METRES_A_NEWTON = 0.02


class RerunLog:
    """Logs frames. Mutable.

    Args:
        prepared: The scene.
        rerun: The module ``rerun``.
        stream: Its ``RecordingStream``.
        scale: Upper end of the colour scale [kPa].
    """

    def __init__(self, prepared: PreparedScene, rerun: Any, stream: Any, *, scale: float) -> None:
        self._rr = rerun
        self._stream = stream
        self._prepared = prepared
        self._configuration = Configuration(prepared.robot)
        self._image = TactileImage(prepared.map, width=256)
        self._scale = scale
        self._units: ReadingUnits | None = None  # logged with the first tick, and when they change

    def use_map(self, map_: TactileMap) -> None:
        """Use another map of the same skin for the tactile image. Cost: 0.1 s."""
        self._image = TactileImage(map_, width=256)

    def use_scale(self, scale: float) -> None:
        """Change the upper end of the colour scale [kPa]; logged with the next tick."""
        self._scale = scale
        self._units = None

    def open(self) -> None:
        """Log the surfaces, once."""
        prepared = self._prepared
        meshes = [(link.name, link.mesh) for link in prepared.robot.links if link.mesh is not None]
        meshes += [(object_frame(body.spec.name), body.mesh) for body in prepared.objects]
        for name, mesh in meshes:
            surface = self._rr.Mesh3D(
                vertex_positions=mesh.vertices.astype(np.float32),
                triangle_indices=mesh.faces.astype(np.uint32),
                albedo_factor=(190, 194, 199, 255),
            )
            self._stream.log(f"world/{name}/surface", surface, static=True)

    def add(self, frame: Frame) -> None:
        """Log a frame."""
        self._log_units(frame.units)
        rr = self._rr
        prepared = self._prepared
        self._configuration.update(frame.posture)
        poses = np.concatenate([self._configuration.poses(), frame.objects])
        for name, pose in zip(frame_names(prepared), poses, strict=True):
            self._stream.log(f"world/{name}", rr.Transform3D(translation=pose[:3, 3], mat3x3=pose[:3, :3]))
        self._stream.log("tactile_image", rr.Image(colour_image(self._image, frame.pressures, self._scale)))
        self._add_taxels(frame)
        self._add_contacts(frame)
        for joint, position in zip(prepared.robot.joints, frame.posture.tolist(), strict=True):
            self._stream.log(f"joints/{joint.name}", rr.Scalars(position))

    def _add_taxels(self, frame: Frame) -> None:
        skin = self._prepared.skin
        levels = np.nan_to_num(1e-3 * frame.pressures * (255 / self._scale))
        colours = COLOURS[np.rint(np.clip(levels, 0, 255)).astype(int)]
        for number, patch in enumerate(skin.patches):
            own = slice(int(skin.first[number]), int(skin.first[number + 1]))
            points = self._rr.Points3D(patch.taxels.positions, colors=colours[own], radii=0.002)
            self._stream.log(f"world/{patch.link}/taxels/{patch.name}", points)

    def _add_contacts(self, frame: Frame) -> None:
        for link in self._prepared.skin.links:
            own = [region for region in frame.regions if region.link == link]
            arrows = self._rr.Arrows3D(
                origins=[one.link_position - _METRES_A_NEWTON * one.force_vector for one in own],
                vectors=[_METRES_A_NEWTON * one.force_vector for one in own],
                colors=[(31, 119, 180)] * len(own),
                labels=[frame.units.contact_words(one.force, one.peak, 2, space=" ") for one in own],
            )
            self._stream.log(f"world/{link}/contacts", arrows)
        if frame.units.force is not None:
            force = sum(region.force for region in frame.regions)
            self._stream.log("contacts/force", self._rr.Scalars(force))
            if frame.shear is not None:
                along = sum(length(np.array(one.shear.force)) for one in frame.regions if one.shear is not None)
                self._stream.log("contacts/shear", self._rr.Scalars(along))

    def _log_units(self, units: ReadingUnits) -> None:
        if units is not self._units:
            self._units = units
            words = f"Colours: 0 to {self._scale:g} {units.unit}"
            self._stream.log("tactile_image/scale", self._rr.TextDocument(words))
