"""Messages of ROS 2: from a bag (SQLite or MCAP), or live if ``rclpy`` is installed with the system.

A TOML file defines the topic and field of the values:

    [readings]
    topic = "/skin/readings"
    values = "data"            # field of the message: an array of numbers; "parts.*.values" joins those of a list;
                               # ["left.force", "right.force"] joins several fields, also single numbers
    ids = "ids"                # field with an id for each value, or a list of ids; optional
    stamp = "header.stamp"     # field of the time; default: when the message was received
    unit = "counts"
    type = "std_msgs/msg/Float32MultiArray"   # required for live messages only

    [joints]                   # optional
    topic = "/joint_states"    # sensor_msgs/msg/JointState

Messages are CDR bytes in both cases and are decoded by ``rosbags``.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit, labels_of, unit_of
from tactile_maps.live.readings.tables import read_toml
from tactile_maps.live.sources.files import Item

_INSTALL = "Install it with: pip install 'tactile-maps[ros]'"
_JOINT_STATE = "sensor_msgs/msg/JointState"


@dataclass(frozen=True)
class RosTopics:
    """Location of readings in ROS messages.

    Attributes:
        topic: Topic of the readings.
        values: Fields of the values, whose numbers are joined, with dots between parts; ``*`` is each of a list.
        ids: Field of the ids, or the ids; None if there are none.
        stamp: Field of the time; None for the time of reception.
        unit: Unit of the values.
        type: Type of the message; required for live messages only.
        joints: Topic of joint states; None if there is none.
    """

    topic: str
    values: str | tuple[str, ...]
    ids: str | tuple[int | str, ...] | None = None
    stamp: str | None = None
    unit: Unit = Unit.COUNTS
    type: str | None = None
    joints: str | None = None


def load_topics(path: Path | None) -> RosTopics:
    """Read the mapping in a TOML file.

    Raises:
        UsageError: No file is given.
        LiveError: The file cannot be read or is invalid.
    """
    if path is None:
        remedy = "Give a TOML file with [readings] topic and values as the mapping"
        raise UsageError("messages of ROS need a mapping", remedy=remedy)
    table = read_toml(path)
    readings = table.pop("readings", None)
    joints = table.pop("joints", {})
    if table or not isinstance(readings, dict) or not isinstance(joints, dict):
        remedy = "Its tables are: [readings] and optionally [joints]"
        raise LiveError("this is not a mapping", file=path, value=next(iter(table), None), remedy=remedy)
    known = {"topic", "values", "ids", "stamp", "unit", "type"}
    for place, found, keys in (("readings", readings, known), ("joints", joints, {"topic"})):
        if more := found.keys() - keys:
            remedy = f"Allowed keys: {', '.join(sorted(keys))}"
            raise LiveError("unknown key", file=path, place=f"{place}.{min(more)}", remedy=remedy)
    ids = readings.get("ids")
    if isinstance(ids, list):
        if not all(isinstance(one, int | str) and not isinstance(one, bool) for one in ids):
            raise LiveError("expected whole numbers, or texts link:id", file=path, place="readings.ids")
        ids = tuple(ids)
    values = readings.get("values")
    if isinstance(values, list):
        if not (values and all(isinstance(one, str) for one in values)):
            raise LiveError("expected texts", file=path, place="readings.values", value=values)
        readings["values"] = values[0]
    words = {f"readings.{key}": readings.get(key) for key in ("topic", "values", "stamp", "type")}
    words |= {"joints.topic": joints.get("topic")} | ({} if isinstance(ids, tuple) else {"readings.ids": ids})
    for place, word in words.items():
        if not isinstance(word, str | None) or (word is None and place in ("readings.topic", "readings.values")):
            raise LiveError("expected a text", file=path, place=place, value=word)
    try:
        unit = unit_of(readings.get("unit", "counts"))
    except MalformedReadingError as error:
        raise error.at(kind=LiveError, file=path, place="readings.unit") from error
    fields = tuple(values) if isinstance(values, list) else readings["values"]
    return RosTopics(
        readings["topic"], fields, ids, readings.get("stamp"), unit, readings.get("type"), joints.get("topic")
    )


@dataclass
class MessageReader:
    """Converts messages to readings with the latest joint positions. Mutable.

    Attributes:
        topics: Location of readings in the messages.
        joints: The latest positions by name.
    """

    topics: RosTopics
    joints: Mapping[str, float] = field(default_factory=dict)

    def read(self, topic: str, message: Any, received: float) -> Reading | None:
        """Return the reading of a message; None for a message with joints only.

        Raises:
            MalformedReadingError: Its fields do not match the mapping.
        """
        topics = self.topics
        if topic == topics.joints:
            self.joints = dict(zip(message.name, map(float, message.position), strict=False))
            return None
        try:
            paths = (topics.values,) if isinstance(topics.values, str) else topics.values
            fields = [value for path in paths for value in _fields(message, path.split("."))]
            values = np.concatenate([np.asarray(value, dtype=np.float64).reshape(-1) for value in fields])
            ids = _field(message, topics.ids) if isinstance(topics.ids, str) else topics.ids
            at = received
            if topics.stamp is not None:
                stamp = _field(message, topics.stamp)
                at = stamp.sec + 1e-9 * stamp.nanosec
        except (AttributeError, TypeError, ValueError) as error:
            raise MalformedReadingError("a message does not match the mapping", place=topic, value=error) from error
        links, labels = (None, None) if ids is None else _labels(ids)
        return Reading(at, values, topics.unit, labels, joints=self.joints, links=links)


def _labels(ids: Sequence[int | str]) -> tuple[tuple[str, ...] | None, IntArray]:
    """Return the links and numbers of ids; numbers alone have no links."""
    numbers = np.asarray(ids)
    if numbers.dtype.kind in "US":
        return labels_of([str(one) for one in ids])
    return None, numbers.astype(np.int64)


def _fields(message: Any, names: Sequence[str]) -> Iterator[Any]:
    """Yield the values at a path; ``*`` is each message of a list."""
    if not names:
        yield message
    elif names[0] == "*":
        for one in message:
            yield from _fields(one, names[1:])
    else:
        yield from _fields(getattr(message, names[0]), names[1:])


def _field(message: Any, path: str) -> Any:
    for name in path.split("."):
        message = getattr(message, name)
    return message


def import_rosbags() -> Any:
    """Return the optional library ``rosbags``.

    Raises:
        LiveError: It is not installed.
    """
    try:
        import rosbags.highlevel
        import rosbags.typesys
    except ImportError as error:
        raise LiveError("messages of ROS need rosbags", remedy=_INSTALL) from error
    return rosbags


def read_bag(path: Path, topics: RosTopics) -> Iterator[Item]:
    """Yield the readings of a bag: a folder recorded by ROS 2, or its MCAP or SQLite file.

    Raises:
        LiveError: It cannot be read, or does not contain the topic.
    """
    rosbags = import_rosbags()
    store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_HUMBLE)
    folder = path if os.path.isdir(path) else path.parent
    reader = MessageReader(topics)
    try:
        with rosbags.highlevel.AnyReader([folder], default_typestore=store) as bag:
            selected = [one for one in bag.connections if one.topic in (topics.topic, topics.joints)]
            if not any(connection.topic == topics.topic for connection in selected):
                known = ", ".join(sorted({connection.topic for connection in bag.connections})) or "none"
                problem = "the bag does not contain the topic"
                raise LiveError(problem, file=path, value=topics.topic, remedy=f"Its topics are: {known}")
            for connection, nanoseconds, raw in bag.messages(connections=selected):
                try:
                    message = bag.deserialize(raw, connection.msgtype)
                    reading = reader.read(connection.topic, message, 1e-9 * nanoseconds)
                except MalformedReadingError as error:
                    yield error
                    continue
                if reading is not None:
                    yield reading
    except LiveError:
        raise
    except Exception as error:  # rosbags raises many kinds of errors for invalid files
        remedy = "Give the folder that ros2 bag record made, with its metadata.yaml"
        raise LiveError("the bag cannot be read", file=path, value=error, remedy=remedy) from error


class Ros2Source:
    """Readings of a running ROS 2 system. Mutable.

    Args:
        topics: Location of readings in its messages, with the type.

    Attributes:
        address: Address for display.
        finite: False.
        slow: True.

    Raises:
        LiveError: The mapping has no type.
    """

    finite = False
    slow = True

    def __init__(self, topics: RosTopics) -> None:
        if topics.type is None:
            remedy = 'Add the type to [readings], for example type = "std_msgs/msg/Float32MultiArray"'
            raise LiveError("the mapping does not state the type of the messages", place="readings.type", remedy=remedy)
        self.address = f"ros2:{topics.topic}"
        self._topics = topics
        self._reader = MessageReader(topics)
        self._node: Any = None
        self._context: Any = None
        self._rclpy: Any = None
        self._arrived: deque[tuple[str, bytes]] = deque()

    def open(self) -> None:
        """Subscribe; raises LiveError if ROS 2 is not installed or does not know the type."""
        try:
            import rclpy  # type: ignore[import-not-found,unused-ignore]
            from rosidl_runtime_py.utilities import get_message  # type: ignore[import-not-found,unused-ignore]
        except ImportError as error:
            remedy = "Install ROS 2 and source its setup file before starting, or play a bag of the topic"
            raise LiveError("ROS 2 is not installed", value=error, remedy=remedy) from error
        rosbags = import_rosbags()
        self._store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_HUMBLE)
        self._rclpy = rclpy
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node("tactile_maps", context=self._context)
        assert self._topics.type is not None
        self._types = {self._topics.topic: self._topics.type}
        if self._topics.joints is not None:
            self._types[self._topics.joints] = _JOINT_STATE
        for topic, kind in self._types.items():
            try:
                message = get_message(kind)
            except (AttributeError, ModuleNotFoundError, ValueError) as error:
                self.close()
                raise LiveError("ROS 2 does not know the type of the messages", place=topic, value=kind) from error
            self._node.create_subscription(message, topic, partial(self._keep, topic), 100, raw=True)

    def _keep(self, topic: str, raw: Any) -> None:
        self._arrived.append((topic, bytes(raw)))

    def receive(self, timeout: float) -> Reading | None:
        """Return the reading of the next message."""
        if self._node is None:
            raise LiveError("the source is not open", place=self.address)
        if not self._arrived:
            self._rclpy.spin_once(self._node, timeout_sec=timeout)
        if not self._arrived:
            return None
        topic, raw = self._arrived.popleft()
        try:
            message = self._store.deserialize_cdr(raw, self._types[topic])
        except Exception as error:  # rosbags raises many kinds of errors for invalid bytes
            raise MalformedReadingError("a message cannot be read", place=topic, value=error) from error
        return self._reader.read(topic, message, time.time())

    def close(self) -> None:
        """Unsubscribe."""
        if self._node is not None:
            self._node.destroy_node()
            self._rclpy.shutdown(context=self._context)
            self._node = None
