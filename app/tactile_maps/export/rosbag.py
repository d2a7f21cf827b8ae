"""A recording as a ROS 2 bag (MCAP storage), which ``ros2 bag play``, RViz and PlotJuggler read; no ROS is needed here.

| topic | type | how often |
|---|---|---|
| ``/joint_states`` | sensor_msgs/JointState | each tick; effort is empty because torques are not measured |
| ``/skin/pressures`` | std_msgs/Float32MultiArray [Pa] | each tick, by taxel in the order of the labels |
| ``/skin/readings`` | the same, in counts | instead, if a real skin is not calibrated |
| ``/skin/taxels`` | std_msgs/String | once, transient local: the labels of the taxels as JSON |
| ``/skin/contacts`` | tactile_maps_msgs/SkinContacts | each tick: wrenches and covariances of contacts and links |
| ``/tf`` | tf2_msgs/TFMessage | at the rate of pictures |
| ``/taxels/LINK`` | sensor_msgs/PointCloud2 | the same, in the link's frame |
| ``/tactile_image`` | sensor_msgs/Image, 32FC1 [kPa, or counts] | the same |
| ``/contacts`` | visualization_msgs/MarkerArray | the same: an arrow of 20 mm per newton for each contact |
| ``/skin/shear`` | std_msgs/Float32MultiArray, (n, 2) [Pa, or counts] | each tick with shear: t1 and t2 of each |
| ``/events`` | std_msgs/String | each contact event at its tick, in words |
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import packages_of
from tactile_maps.core.progress import Progress
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.export.contact_messages import (
    CONTACTS_TYPE,
    MESSAGE_TEXTS,
    UncertainWrench,
    contact_wrench,
    link_wrench,
    outline,
)
from tactile_maps.export.tables import paced_frames, taxel_labels
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.recording.encoding.viewer_messages import frame_names
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame

_WORLD = "world"
_METRES_A_NEWTON = 0.02
_LABELS = "/skin/taxels"
_ADD = 0
_DELETE_ALL = 3
_ARROW = 0
_FLOAT32 = 7


def write_rosbag(player: RecordingPlayer, folder: Path, *, rate: float, progress: Progress) -> None:
    """Write the bag to a new folder: ``metadata.yaml`` and an MCAP file with the name of the recording.

    Raises:
        ExportError: The package is not installed.
    """
    with packages_of("export"):
        import rosbags.rosbag2 as rosbag2
    # The library names the file after its folder, also in metadata.yaml, and ``folder`` has a temporary name.
    made = folder / "part" / (player.path.stem.lstrip(".") or "recording")
    with rosbag2.Writer(made, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        bag = _Bag(player, writer)
        bag.open()
        for frame, due, events in paced_frames(player, rate, progress):
            bag.add_state(frame)
            if due:
                bag.add_pictures(frame)
            for event in events:
                bag.add_words("/events", frame.tick, event.words)
    for file in list(made.iterdir()):
        file.rename(folder / file.name)
    made.rmdir()
    made.parent.rmdir()


def _transient_local() -> Any:
    """Return the quality of service of a message that is sent once and kept for later subscribers."""
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    unlimited = QosTime(0, 0)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL,
        deadline=unlimited,
        lifespan=unlimited,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=unlimited,
        avoid_ros_namespace_conventions=False,
    )


class _Bag:
    """Converts frames to messages. Mutable: connections are created when a topic is first used."""

    def __init__(self, player: RecordingPlayer, writer: Any) -> None:
        from rosbags import typesys

        self._types = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        for name, text in MESSAGE_TEXTS.items():
            self._types.register(typesys.get_types_from_msg(text, name))
        self._writer = writer
        self._prepared = player.prepared
        self._started = int(player.versions.get("started_ns", 0))
        self._first = round(float(player.times[0]) / player.prepared.scene.tick)
        self._connections: dict[str, Any] = {}
        self._configuration = Configuration(player.prepared.robot)
        self._image = TactileImage(player.prepared.map, width=128)

    def open(self) -> None:
        """Write the messages that are written once."""
        self.add_words(_LABELS, self._first, json.dumps(taxel_labels(self._prepared.skin)))

    def add_words(self, topic: str, tick: int, text: str) -> None:
        """Write a text message."""
        self._write(topic, tick, self._make("std_msgs/msg/String", data=text))

    def add_state(self, frame: Frame) -> None:
        """Write joints and pressures."""
        joints = self._make(
            "sensor_msgs/msg/JointState",
            header=self._header(frame.tick, ""),
            name=list(self._prepared.robot.joint_names),
            position=frame.posture,
            velocity=frame.velocity,
            effort=np.zeros(0),
        )
        self._write("/joint_states", frame.tick, joints)
        calibrated = frame.units is not ReadingUnits.COUNTS
        unit = 1.0 if calibrated else 1e-3
        self._add_array("/skin/pressures" if calibrated else "/skin/readings", frame.tick, unit * frame.pressures)
        if frame.shear is not None:
            self._add_array("/skin/shear", frame.tick, unit * frame.shear)
        self._write("/skin/contacts", frame.tick, self._contacts(frame))

    def _add_array(self, topic: str, tick: int, values: FloatArray) -> None:
        """Write values (taxels,) or (taxels, 2)."""
        dimensions = [
            self._make(
                "std_msgs/msg/MultiArrayDimension", label=label, size=size, stride=math.prod(values.shape[axis:])
            )
            for axis, (label, size) in enumerate(zip(("taxel", "axis"), values.shape, strict=False))
        ]
        layout = self._make("std_msgs/msg/MultiArrayLayout", dim=dimensions, data_offset=0)
        data = values.astype(np.float32).ravel()
        self._write(topic, tick, self._make("std_msgs/msg/Float32MultiArray", layout=layout, data=data))

    def _contacts(self, frame: Frame) -> Any:
        links = dict.fromkeys(region.link for region in frame.regions)
        by_link = {link: [region for region in frame.regions if region.link == link] for link in links}
        return self._make(
            CONTACTS_TYPE,
            header=self._header(frame.tick, ""),
            contacts=[self._contact(frame, region) for region in frame.regions],
            links=[
                self._make(
                    "tactile_maps_msgs/msg/LinkWrench", link=link, **self._wrench(frame, link_wrench(by_link[link]))
                )
                for link in links
            ],
        )

    def _contact(self, frame: Frame, region: ContactRegion) -> Any:
        corners = outline(region, frame, self._prepared.skin)
        points = [self._vector("Point32", corner) for corner in corners]
        return self._make(
            "tactile_maps_msgs/msg/SkinContact",
            id=region.id,
            link=region.link,
            region=self._make("geometry_msgs/msg/Polygon", points=points),
            position=self._vector("Point", region.link_position),
            normal=self._vector("Vector3", region.link_normal),
            area=region.area,
            peak=region.peak,
            **self._wrench(frame, contact_wrench(region)),
        )

    def _wrench(self, frame: Frame, found: UncertainWrench) -> dict[str, Any]:
        known = 1.0 if frame.units.force is not None else math.nan
        wrench = known * found.wrench
        message = self._make(
            "geometry_msgs/msg/Wrench",
            force=self._vector("Vector3", wrench[:3]),
            torque=self._vector("Vector3", wrench[3:]),
        )
        return {"wrench": message, "covariance": known * found.covariance.ravel()}

    def add_pictures(self, frame: Frame) -> None:
        """Write transforms, taxels, tactile image and contacts."""
        self._configuration.update(frame.posture)
        self._write("/tf", frame.tick, self._make("tf2_msgs/msg/TFMessage", transforms=self._transforms(frame)))
        for link in self._prepared.skin.links:
            self._write(f"/taxels/{link}", frame.tick, self._cloud(frame, link))
        values = self._image.render(frame.pressures)
        image = self._make(
            "sensor_msgs/msg/Image",
            header=self._header(frame.tick, "tactile_map"),
            height=values.shape[0],
            width=values.shape[1],
            encoding="32FC1",
            is_bigendian=0,
            step=4 * values.shape[1],
            data=values.ravel().view(np.uint8),
        )
        self._write("/tactile_image", frame.tick, image)
        self._write("/contacts", frame.tick, self._markers(frame))

    def _write(self, topic: str, tick: int, message: Any) -> None:
        kind = message.__msgtype__
        if topic not in self._connections:
            profiles = [_transient_local()] if topic == _LABELS else []
            self._connections[topic] = self._writer.add_connection(
                topic, kind, typestore=self._types, offered_qos_profiles=profiles
            )
        self._writer.write(self._connections[topic], self._time(tick), self._types.serialize_cdr(message, kind))

    def _make(self, kind: str, **fields: Any) -> Any:
        return self._types.types[kind](**fields)

    def _time(self, tick: int) -> int:
        return self._started + round(1e9 * tick * self._prepared.scene.tick)

    def _header(self, tick: int, frame_id: str) -> Any:
        seconds, rest = divmod(self._time(tick), 10**9)
        stamp = self._make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)
        return self._make("std_msgs/msg/Header", stamp=stamp, frame_id=frame_id)

    def _vector(self, kind: str, values: Any) -> Any:
        return self._make(f"geometry_msgs/msg/{kind}", **dict(zip("xyzw", map(float, values), strict=False)))

    def _transforms(self, frame: Frame) -> list[Any]:
        names = frame_names(self._prepared)
        poses = np.concatenate([self._configuration.poses(), frame.objects])
        turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
        return [
            self._make(
                "geometry_msgs/msg/TransformStamped",
                header=self._header(frame.tick, _WORLD),
                child_frame_id=name,
                transform=self._make(
                    "geometry_msgs/msg/Transform",
                    translation=self._vector("Vector3", pose[:3, 3]),
                    rotation=self._vector("Quaternion", turn),
                ),
            )
            for name, pose, turn in zip(names, poses, turns, strict=True)
        ]

    def _cloud(self, frame: Frame, link: str) -> Any:
        skin = self._prepared.skin
        own = [number for number, patch in enumerate(skin.patches) if patch.link == link]
        taxels = np.flatnonzero(np.isin(skin.patch_of, own))
        positions = np.concatenate([skin.patches[number].taxels.positions for number in own])
        points = np.column_stack([positions, 1e-3 * frame.pressures[taxels]]).astype(np.float32)
        fields = [
            self._make("sensor_msgs/msg/PointField", name=name, offset=4 * place, datatype=_FLOAT32, count=1)
            for place, name in enumerate(("x", "y", "z", frame.units.noun))
        ]
        return self._make(
            "sensor_msgs/msg/PointCloud2",
            header=self._header(frame.tick, link),
            height=1,
            width=len(points),
            fields=fields,
            is_bigendian=False,
            point_step=16,
            row_step=16 * len(points),
            data=points.ravel().view(np.uint8),
            is_dense=bool(np.isfinite(points).all()),
        )

    def _markers(self, frame: Frame) -> Any:
        markers = [self._marker(frame.tick, _WORLD, 0, _DELETE_ALL, [], "")]
        for region in frame.regions:
            ends = [region.link_position - _METRES_A_NEWTON * region.force_vector, region.link_position]
            words = frame.units.contact_words(region.force, region.peak, 2, space=" ")
            markers.append(self._marker(frame.tick, region.link, region.id, _ADD, ends, words))
        return self._make("visualization_msgs/msg/MarkerArray", markers=markers)

    def _marker(self, tick: int, link: str, number: int, action: int, ends: list[Any], text: str) -> Any:
        nothing = np.zeros(0, dtype=np.uint8)
        texture = self._make("sensor_msgs/msg/CompressedImage", header=self._header(tick, ""), format="", data=nothing)
        return self._make(
            "visualization_msgs/msg/Marker",
            header=self._header(tick, link),
            ns="contacts",
            id=number,
            type=_ARROW,
            action=action,
            pose=self._make(
                "geometry_msgs/msg/Pose",
                position=self._vector("Point", (0, 0, 0)),
                orientation=self._vector("Quaternion", (0, 0, 0, 1)),
            ),
            scale=self._vector("Vector3", (0.004, 0.008, 0.0)),
            color=self._make("std_msgs/msg/ColorRGBA", r=0.12, g=0.47, b=0.71, a=1.0),
            lifetime=self._make("builtin_interfaces/msg/Duration", sec=0, nanosec=0),
            frame_locked=True,
            points=[self._vector("Point", end) for end in ends],
            colors=[],
            texture_resource="",
            texture=texture,
            uv_coordinates=[],
            text=text,
            mesh_resource="",
            mesh_file=self._make("visualization_msgs/msg/MeshFile", filename="", data=nothing),
            mesh_use_embedded_materials=False,
        )
