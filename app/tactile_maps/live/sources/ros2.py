"""Messages of ROS 2: from a bag (SQLite or MCAP), or live where ``rclpy`` is installed with the system.

Which topic and field the values are in, a TOML file says:

    [readings]
    topic = "/skin/readings"
    values = "data"            # field of the message: an array of numbers; "parts.*.values" joins those of a list;
                               # ["left.force", "right.force"] joins several fields, also single numbers
    ids = "ids"                # field with an id for each value, or a list of ids; left out where there are none
    stamp = "header.stamp"     # field of the time; left out: when the message was received
    unit = "counts"
    type = "std_msgs/msg/Float32MultiArray"   # needed live only

    [joints]                   # left out where the posture is not published
    topic = "/joint_states"    # sensor_msgs/msg/JointState

Messages come as CDR bytes either way, and are read by ``rosbags``.
"""

from __future__ import annotations

import os
import time
import tomllib
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.core.files import read_bounded_text
from tactile_maps.core.toml import parse_toml
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit, unit_of
from tactile_maps.live.sources.files import Item

_INSTALL = "Install it with: pip install 'tactile-maps[ros]'"
_JOINT_STATE = "sensor_msgs/msg/JointState"


@dataclass(frozen=True)
class RosTopics:
    """Where in ROS messages readings are.

    Attributes:
        topic: Of the readings.
        values: Fields of the values, whose numbers are joined, with dots between parts; ``*`` is each of a list.
        ids: Field of the ids, or the ids; None where there are none.
        stamp: Field of the time; None for when the message was received.
        unit: Of the values.
        type: Of the message; needed live only.
        joints: Topic of joint states; None where there is none.
    """

    topic: str
    values: str | tuple[str, ...]
    ids: str | tuple[int, ...] | None = None
    stamp: str | None = None
    unit: Unit = Unit.COUNTS
    type: str | None = None
    joints: str | None = None


def load_topics(path: Path | None) -> RosTopics:
    """The mapping in a TOML file.

    Raises:
        UsageError: No file is named.
        LiveError: It cannot be read, or says what it cannot.
    """
    if path is None:
        remedy = "Name a TOML file with [readings] topic and values as the mapping"
        raise UsageError("messages of ROS need a mapping", remedy=remedy)
    try:
        text = read_bounded_text(path, error=LiveError)
        table = parse_toml(text, file=path, error=LiveError)
    except tomllib.TOMLDecodeError as error:
        raise LiveError("the file is not TOML", file=path, value=error) from error
    readings = table.pop("readings", None)
    joints = table.pop("joints", {})
    if table or not isinstance(readings, dict) or not isinstance(joints, dict):
        remedy = "Its tables are: [readings] and, if wanted, [joints]"
        raise LiveError("this is no mapping", file=path, value=next(iter(table), None), remedy=remedy)
    known = {"topic", "values", "ids", "stamp", "unit", "type"}
    for place, found, keys in (("readings", readings, known), ("joints", joints, {"topic"})):
        if more := found.keys() - keys:
            remedy = f"The keys are: {', '.join(sorted(keys))}"
            raise LiveError("a key is not known", file=path, place=f"{place}.{min(more)}", remedy=remedy)
    ids = readings.get("ids")
    if isinstance(ids, list):
        if not all(isinstance(one, int) and not isinstance(one, bool) for one in ids):
            raise LiveError("expected whole numbers", file=path, place="readings.ids")
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
    return RosTopics(readings["topic"], fields, ids, readings.get("stamp"), unit, readings.get("type"),
                     joints.get("topic"))  # fmt: skip


@dataclass
class MessageReader:
    """Turns messages into readings; joints are those told last. Mutable.

    Attributes:
        topics: Where in the messages readings are.
        joints: The last positions by name.
    """

    topics: RosTopics
    joints: Mapping[str, float] = field(default_factory=dict)

    def read(self, topic: str, message: Any, received: float) -> Reading | None:
        """The reading of a message; None of one that tells only joints.

        Raises:
            MalformedReadingError: Its fields are not as the mapping says.
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
            raise MalformedReadingError("a message is not as the mapping says", place=topic, value=error) from error
        labels = None if ids is None else np.asarray(ids, dtype=np.int64)
        return Reading(at, values, topics.unit, labels, joints=self.joints)


def _fields(message: Any, names: Sequence[str]) -> Iterator[Any]:
    """Yield the values at a path; ``*`` stands for each message of a list."""
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
    """The library, which is optional.

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
    """Readings of a bag: a folder as ROS 2 records it, or its MCAP or SQLite file.

    Raises:
        LiveError: It cannot be read, or has no such topic.
    """
    rosbags = import_rosbags()
    store = rosbags.typesys.get_typestore(rosbags.typesys.Stores.ROS2_HUMBLE)
    folder = path if os.path.isdir(path) else path.parent
    reader = MessageReader(topics)
    try:
        with rosbags.highlevel.AnyReader([folder], default_typestore=store) as bag:
            wanted = [connection for connection in bag.connections if connection.topic in (topics.topic, topics.joints)]
            if not any(connection.topic == topics.topic for connection in wanted):
                known = ", ".join(sorted({connection.topic for connection in bag.connections})) or "none"
                problem = "the bag has no such topic"
                raise LiveError(problem, file=path, value=topics.topic, remedy=f"Its topics are: {known}")
            for connection, nanoseconds, raw in bag.messages(connections=wanted):
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
    except Exception as error:  # whatever a foreign library makes of a foreign file
        remedy = "Name the folder that ros2 bag record made, with its metadata.yaml"
        raise LiveError("the bag cannot be read", file=path, value=error, remedy=remedy) from error


class Ros2Source:
    """Readings of a running ROS 2 system. Mutable.

    Args:
        topics: Where in its messages readings are; the type must be named.

    Attributes:
        address: For people.
        finite: False.
        slow: True.

    Raises:
        LiveError: The mapping names no type.
    """

    finite = False
    slow = True

    def __init__(self, topics: RosTopics) -> None:
        if topics.type is None:
            remedy = 'Add type = "std_msgs/msg/Float32MultiArray", or whatever it is, to [readings]'
            raise LiveError("the mapping does not name the type of the messages", place="readings.type", remedy=remedy)
        self.address = f"ros2:{topics.topic}"
        self._topics = topics
        self._reader = MessageReader(topics)
        self._node: Any = None
        self._context: Any = None
        self._rclpy: Any = None
        self._arrived: deque[tuple[str, bytes]] = deque()

    def open(self) -> None:
        """Subscribe; raises LiveError where ROS 2 is not installed, or does not know the type."""
        try:
            import rclpy  # type: ignore[import-not-found,unused-ignore]
            from rosidl_runtime_py.utilities import get_message  # type: ignore[import-not-found,unused-ignore]
        except ImportError as error:
            remedy = "Install ROS 2 and source its setup file before starting, or play a bag of the topic"
            raise LiveError("there is no ROS 2 on this machine", value=error, remedy=remedy) from error
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
        """The reading of the next message."""
        if self._node is None:
            raise LiveError("the source is not open", place=self.address)
        if not self._arrived:
            self._rclpy.spin_once(self._node, timeout_sec=timeout)
        if not self._arrived:
            return None
        topic, raw = self._arrived.popleft()
        try:
            message = self._store.deserialize_cdr(raw, self._types[topic])
        except Exception as error:  # whatever a foreign library makes of foreign bytes
            raise MalformedReadingError("a message cannot be read", place=topic, value=error) from error
        return self._reader.read(topic, message, time.time())

    def close(self) -> None:
        """Unsubscribe."""
        if self._node is not None:
            self._node.destroy_node()
            self._rclpy.shutdown(context=self._context)
            self._node = None
