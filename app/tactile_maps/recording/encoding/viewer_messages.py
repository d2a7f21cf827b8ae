"""Messages that viewers of other programs display: Foxglove, Lichtblick, Rerun.

A recording contains them in addition to its own exact messages, and the live server sends them. They use Foxglove's
well-known schemas in Protobuf, with the schema text of its SDK. They show the session at a limited rate in single
precision; a replay does not read them.

| topic | schema | content |
|---|---|---|
| ``/tactile_image`` | RawImage | the tactile image in colours, 96 pixels on its longer side |
| ``/taxels/LINK`` | PointCloud | position of each taxel [m, to 15 µm], pressure [kPa], number, id; in the link's frame
| | ``/tf`` | FrameTransforms | links and objects in ``world`` | | ``/joint_states`` | JointStates | position and
velocity | | ``/contacts`` | SceneUpdate | an ellipse, an arrow (20 mm per newton) and the force of each contact region
| | ``/robot`` | SceneUpdate | the surfaces of links and objects, once | | ``/events`` | Log | contact events, a new
colour scale, why a session stopped; each at its tick |
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import foxglove.messages as fox
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.maps.pressure_colours import colour_image, rounded_scale
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Failure, Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin

RATE = 20.0
"""Rate of all messages except events [Hz]."""
_GRID = 2.0**16
"""Taxel positions are rounded to 1 / this [m], 15 µm, which reduces their compressed size by a quarter."""
ENCODING = "protobuf"
IMAGE_WIDTH = 96
WORLD = "world"
_IMAGE = "/tactile_image"
_TF = "/tf"
_JOINTS = "/joint_states"
CONTACTS_TOPIC = "/contacts"
ROBOT_TOPIC = "/robot"
_EVENTS = "/events"
_METRES_A_NEWTON = 0.02
_SHEAR = ("shear_t1", "shear_t2")
"""Fields of the shear [kPa] of taxels with three axes."""
_TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)
_CIRCLE = np.stack([np.cos(_TURN), np.sin(_TURN)], axis=1)
_NUMBERS = fox.PackedElementFieldNumericType
_CONTACT_COLOUR = fox.Color(r=0.12, g=0.47, b=0.71, a=1.0)
_LINK_COLOUR = fox.Color(r=0.75, g=0.76, b=0.78, a=1.0)
_OBJECT_COLOUR = fox.Color(r=0.55, g=0.6, b=0.5, a=1.0)


@dataclass(frozen=True)
class Schema:
    """Schema of a topic: name, encoding and text as bytes."""

    name: str
    encoding: str
    data: bytes


Message = tuple[str, bytes]
"""Topic and content."""


class ViewerMessages:
    """Messages of one session. Mutable: tracks which events were written. Construction takes 20 ms for 1000 taxels.

    Args:
        prepared: The scene of the session.
        started: Wall-clock time of tick 0 [ns since 1970].
        rate: Rate of all messages except events [Hz]; at most one per tick.

    Attributes:
        schemas: Schema by topic.
    """

    def __init__(self, prepared: PreparedScene, *, started: int) -> None:
        self._prepared = prepared
        self._started = started
        self._tick_s = prepared.scene.tick
        self._every = max(round(1.0 / (RATE * self._tick_s)), 1)
        self._due = -1
        self._latest = -1
        self._scale = 0.0
        self._units = ReadingUnits.CALIBRATED
        self._configuration = Configuration(prepared.robot)
        self._clouds = [_Cloud(prepared.skin, link) for link in prepared.skin.links]
        self.use_map(prepared.map)
        self.schemas: Mapping[str, Schema] = viewer_schemas(prepared)

    def use_map(self, map_: TactileMap) -> None:
        """Use ``map_`` for the tactile image from now on. Cost: 15 ms for 1000 taxels."""
        self._image = TactileImage(map_, width=IMAGE_WIDTH)

    def opening(self, tick: int) -> list[Message]:
        """Return the surfaces of robot and objects, which are sent once. Cost: 20 ms for 30,000 triangles."""
        time = self._time(tick)
        entities = [
            _surface(link.name, link.mesh, time, _LINK_COLOUR)
            for link in self._prepared.robot.links
            if link.mesh is not None
        ]
        entities += [
            _surface(object_frame(body.spec.name), body.mesh, time, _OBJECT_COLOUR) for body in self._prepared.objects
        ]
        return [(ROBOT_TOPIC, fox.SceneUpdate(entities=entities).encode())]

    def of(self, frame: Frame) -> list[Message]:
        """Return the messages of a tick: new events, and the rest when it is due.

        Cost: 0.3 ms for 1000 taxels when due, otherwise 1 µs; a few µs per event.
        """
        new = [event for event in frame.recent if event.tick > self._latest][::-1]
        self._latest = frame.tick
        messages = [self._log(event.tick, fox.LogLevel.Info, event.words) for event in new]
        if frame.tick < self._due:
            return messages
        self._due = (frame.tick // self._every + 1) * self._every
        time = self._time(frame.tick)
        messages += self._pictures(frame, time)
        self._configuration.update(frame.posture)
        messages.append((_TF, self._transforms(frame, time)))
        joints = [
            fox.JointState(name=joint.name, position=position, velocity=velocity)
            for joint, position, velocity in zip(
                self._prepared.robot.joints, frame.posture.tolist(), frame.velocity.tolist(), strict=True
            )
        ]
        messages.append((_JOINTS, fox.JointStates(timestamp=time, joints=joints).encode()))
        messages.append((CONTACTS_TOPIC, _contacts(frame.regions, time, frame.units)))
        return messages

    def of_failure(self, failure: Failure) -> list[Message]:
        """Return the message that states why the session stopped."""
        return [self._log(failure.tick, fox.LogLevel.Fatal, failure.problem)]

    def _time(self, tick: int) -> fox.Timestamp:
        seconds, nanoseconds = divmod(self._started + round(1e9 * tick * self._tick_s), 10**9)
        return fox.Timestamp(seconds, nanoseconds)

    def _log(self, tick: int, level: fox.LogLevel, text: str) -> Message:
        message = fox.Log(timestamp=self._time(tick), level=level, message=text, name="tactile-maps")
        return _EVENTS, message.encode()

    def _pictures(self, frame: Frame, time: fox.Timestamp) -> list[Message]:
        """Return the image and the taxel clouds, after a message on the colour scale if it changes."""
        messages = []
        scale = rounded_scale(1e-3 * frame.highest_pressure)
        if scale > self._scale or frame.units is not self._units:
            self._scale = scale
            self._units = frame.units
            words = f"colours of the tactile image: 0 to {scale:g} {frame.units.unit}"
            messages.append(self._log(frame.tick, fox.LogLevel.Info, words))
        picture = colour_image(self._image, frame.pressures, self._scale)
        rows, columns = self._image.shape
        image = fox.RawImage(
            timestamp=time,
            frame_id="tactile_map",
            width=columns,
            height=rows,
            encoding="rgb8",
            step=3 * columns,
            data=picture.tobytes(),
        )
        messages.append((_IMAGE, image.encode()))
        return messages + [(cloud.topic, cloud.message(frame.pressures, frame.shear, time)) for cloud in self._clouds]

    def _transforms(self, frame: Frame, time: fox.Timestamp) -> bytes:
        names = frame_names(self._prepared)
        poses = np.concatenate([self._configuration.poses(), frame.objects])
        turns = Rotation.from_matrix(poses[:, :3, :3]).as_quat().tolist()
        transforms = [
            fox.FrameTransform(
                timestamp=time,
                parent_frame_id=WORLD,
                child_frame_id=name,
                translation=fox.Vector3(x=x, y=y, z=z),
                rotation=fox.Quaternion(x=a, y=b, z=c, w=d),
            )
            for name, (x, y, z), (a, b, c, d) in zip(names, poses[:, :3, 3].tolist(), turns, strict=True)
        ]
        return fox.FrameTransforms(transforms=transforms).encode()


def viewer_schemas(prepared: PreparedScene) -> dict[str, Schema]:
    """Return the schema of each topic of a scene."""
    kinds: dict[str, Any] = {
        _IMAGE: fox.RawImage,
        _TF: fox.FrameTransforms,
        _JOINTS: fox.JointStates,
        CONTACTS_TOPIC: fox.SceneUpdate,
        ROBOT_TOPIC: fox.SceneUpdate,
        _EVENTS: fox.Log,
    }
    kinds |= {_cloud_topic(patch.link): fox.PointCloud for patch in prepared.skin.patches}
    found = {topic: kind.get_schema() for topic, kind in kinds.items()}
    return {topic: Schema(schema.name, schema.encoding, schema.data) for topic, schema in found.items()}


def frame_names(prepared: PreparedScene) -> list[str]:
    """Return the frame names of all links and then all objects of a scene."""
    return [*prepared.robot.link_index, *(object_frame(body.spec.name) for body in prepared.objects)]


def object_frame(name: str) -> str:
    """Return the frame name of an object of the scene; a link may have the same name."""
    return f"object/{name}"


def _cloud_topic(link: str) -> str:
    return f"/taxels/{link}"


class _Cloud:
    """The taxels of one link as packed elements, of which only the pressures change."""

    def __init__(self, skin: Skin, link: str) -> None:
        patches = [number for number, patch in enumerate(skin.patches) if patch.link == link]
        self.topic = _cloud_topic(link)
        self._link = link
        self._taxels: IntArray = np.flatnonzero(np.isin(skin.patch_of, patches))
        taxels = [skin.patches[number].taxels for number in patches]
        ids = [own.identity.ids for own in taxels]
        columns: dict[str, NDArray[np.float64] | IntArray] = dict(
            zip("xyz", (np.rint(_GRID * np.concatenate([own.positions for own in taxels])) / _GRID).T, strict=True)
        )
        columns |= {"pressure": np.zeros(len(self._taxels)), "taxel": self._taxels}
        self._sheared = bool(skin.three_axis[self._taxels].any())
        if self._sheared:
            columns |= dict.fromkeys(_SHEAR, np.zeros(len(self._taxels)))
        if all(own is not None for own in ids):
            columns["id"] = np.concatenate([own for own in ids if own is not None])
        whole = ("taxel", "id")
        self._elements = np.zeros(len(self._taxels), [(name, "<u4" if name in whole else "<f4") for name in columns])
        for name, values in columns.items():
            self._elements[name] = values
        self._fields = [
            fox.PackedElementField(
                name=name, offset=4 * place, type=_NUMBERS.Uint32 if name in whole else _NUMBERS.Float32
            )
            for place, name in enumerate(columns)
        ]

    def message(self, pressures: FloatArray, shear: FloatArray | None, time: fox.Timestamp) -> bytes:
        """Return the message with the pressures (taxels of the skin,) and the shear (taxels, 2) or None [Pa]."""
        self._elements["pressure"] = 1e-3 * pressures[self._taxels]
        if self._sheared:
            for axis, name in enumerate(_SHEAR):
                self._elements[name] = 0.0 if shear is None else 1e-3 * shear[self._taxels, axis]
        cloud = fox.PointCloud(
            timestamp=time,
            frame_id=self._link,
            pose=_pose((0.0, 0.0, 0.0)),
            point_stride=self._elements.itemsize,
            fields=self._fields,
            data=self._elements.tobytes(),
        )
        return cloud.encode()


def _pose(at: Sequence[float], turn: Sequence[float] = (0.0, 0.0, 0.0, 1.0)) -> fox.Pose:
    position = fox.Vector3(**dict(zip("xyz", at, strict=True)))
    return fox.Pose(position=position, orientation=fox.Quaternion(**dict(zip("xyzw", turn, strict=True))))


def _turn_from_x(direction: Sequence[float]) -> tuple[float, float, float, float]:
    """Return the shortest rotation from x, the direction of an arrow, to a unit vector; for half turns one of many."""
    x, y, z = direction
    length = float(np.sqrt(2 * (1 + x))) if x > -1 + 1e-9 else 0.0
    return (0.0, -z / length, y / length, length / 2) if length else (0.0, 0.0, 1.0, 0.0)


def _surface(frame: str, mesh: Mesh, time: fox.Timestamp, colour: fox.Color) -> fox.SceneEntity:
    points = [fox.Point3(x=x, y=y, z=z) for x, y, z in mesh.vertices.tolist()]
    triangles = fox.TriangleListPrimitive(
        pose=_pose((0.0, 0.0, 0.0)), points=points, color=colour, indices=mesh.faces.ravel().tolist()
    )
    return fox.SceneEntity(timestamp=time, frame_id=frame, id=frame, frame_locked=True, triangles=[triangles])


def _contacts(regions: Sequence[ContactRegion], time: fox.Timestamp, units: ReadingUnits) -> bytes:
    """Return the message that replaces all displayed contacts."""
    gone = fox.SceneEntityDeletion(timestamp=time, type=fox.SceneEntityDeletionType.All)
    return fox.SceneUpdate(deletions=[gone], entities=[_contact(region, time, units) for region in regions]).encode()


def _contact(region: ContactRegion, time: fox.Timestamp, units: ReadingUnits) -> fox.SceneEntity:
    """Return an arrow of the force that ends on the skin, the ellipse of the region's second moments, and its words."""
    centre = region.link_position
    normal = region.link_normal
    force = region.force_vector
    strength = float(np.linalg.norm(force))
    direction = force / strength if strength > 0 else -normal
    length = max(_METRES_A_NEWTON * strength, 0.002)
    arrow = fox.ArrowPrimitive(
        pose=_pose((centre - length * direction).tolist(), _turn_from_x(direction.tolist())),
        shaft_length=0.75 * length,
        shaft_diameter=0.004,
        head_length=0.25 * length,
        head_diameter=0.008,
        color=_CONTACT_COLOUR,
    )
    ring = centre + 0.001 * normal + _CIRCLE @ region.link_axes
    ellipse = fox.LinePrimitive(
        type=fox.LinePrimitiveLineType.LineLoop,
        pose=_pose((0.0, 0.0, 0.0)),
        thickness=2.0,
        scale_invariant=True,
        points=[fox.Point3(x=x, y=y, z=z) for x, y, z in ring.tolist()],
        color=_CONTACT_COLOUR,
    )
    text = fox.TextPrimitive(
        pose=_pose((centre - length * direction + 0.01 * normal).tolist()),
        billboard=True,
        font_size=14.0,
        scale_invariant=True,
        color=_CONTACT_COLOUR,
        text=units.contact_words(region.force, region.peak, 2, space=" "),
    )
    return fox.SceneEntity(
        timestamp=time,
        frame_id=region.link,
        id=f"contact {region.id}",
        frame_locked=True,
        arrows=[arrow],
        lines=[ellipse],
        texts=[text],
    )
