"""Messages of ROS 2: from a bag (SQLite or MCAP), or live if ``rclpy`` is installed with the system.

A TOML file defines the topic and field of the values:

    [readings]
    topic = "/skin/readings"
    values = "data"            # field of the values, or a list of fields, whose numbers are joined
    component = "z"            # optional: the values are three numbers per taxel, of which this one is used
    ids = "ids"                # field with an id for each value, or a list of ids; optional
    stamp = "header.stamp"     # field of the time; default: when the message was received
    unit = "counts"
    type = "std_msgs/msg/Float32MultiArray"   # required for live messages only

    [joints]                   # optional
    topic = "/joint_states"    # sensor_msgs/msg/JointState

    [types]                    # optional: definitions of message types that the bag or ROS 2 Humble does not contain
    "my_msgs/msg/Skin" = "float32[] data"

A field has dots between its parts. In a list of messages, ``*`` is each of them, a number is one by its position, and
``name=thumb`` those whose field ``name`` is ``thumb``. A value of NaN means that the taxel did not report.

Messages are CDR bytes in both cases and are decoded by ``rosbags``.
"""

from __future__ import annotations

import os
import re
import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import LiveError, UsageError, install_line
from tactile_maps.live.readings.readings import COMPONENTS, MalformedReadingError, Reading, Unit, labels_of, unit_of
from tactile_maps.live.readings.tables import read_toml
from tactile_maps.live.sources.files import Item

_JOINT_STATE = "sensor_msgs/msg/JointState"
_MISMATCH = "a message does not match the mapping"


@dataclass(frozen=True)
class RosTopics:
    """Location of readings in ROS messages.

    Attributes:
        topic: Topic of the readings.
        values: Fields of the values, whose numbers are joined.
        ids: Field of the ids, or the ids; None if there are none.
        stamp: Field of the time; None for the time of reception.
        unit: Unit of the values.
        type: Type of the message; required for live messages only.
        joints: Topic of joint states; None if there is none.
        component: Value of a taxel that sends three numbers, see ``COMPONENTS``; None for one number.
        types: Definition (text of the .msg file) by type of message.
    """

    topic: str
    values: str | tuple[str, ...]
    ids: str | tuple[int | str, ...] | None = None
    stamp: str | None = None
    unit: Unit = Unit.COUNTS
    type: str | None = None
    joints: str | None = None
    component: str | None = None
    types: Mapping[str, str] = field(default_factory=dict)


def load_topics(path: Path | None) -> RosTopics:
    """Read the mapping in a TOML file.

    Raises:
        UsageError: No file is given.
        LiveError: The file cannot be read or is invalid.
    """
    if path is None:
        remedy = "Give a TOML file with [readings] topic and values as the mapping"
        raise UsageError("messages of ROS need a mapping", remedy=remedy)
    readings, joints, types = _mapping_tables(path)
    ids = _stated_ids(readings, path)
    values = readings.get("values")
    if isinstance(values, list):
        if not (values and all(isinstance(one, str) for one in values)):
            raise LiveError("expected texts", file=path, place="readings.values", value=values)
        readings["values"] = values[0]
    words = {f"readings.{key}": readings.get(key) for key in ("topic", "values", "stamp", "type")}
    words |= {f"types.{name}": text for name, text in types.items()}
    words |= {"joints.topic": joints.get("topic")} | ({} if isinstance(ids, tuple) else {"readings.ids": ids})
    _check_texts(words, path)
    topics = RosTopics(
        readings["topic"],
        tuple(values) if isinstance(values, list) else readings["values"],
        ids,
        readings.get("stamp"),
        _stated_unit(readings, path),
        readings.get("type"),
        joints.get("topic"),
        _stated_component(readings, path),
        types,
    )
    if types:
        try:
            message_types(topics)
        except LiveError as error:
            raise error.at(file=path) from error
    return topics


def _mapping_tables(path: Path) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
    """Return the tables ``readings``, ``joints`` and ``types`` of a mapping with known keys only."""
    table = read_toml(path)
    readings = table.pop("readings", None)
    joints = table.pop("joints", {})
    types = table.pop("types", {})
    if table or not all(isinstance(one, dict) for one in (readings, joints, types)):
        remedy = "Its tables are: [readings] and optionally [joints] and [types]"
        raise LiveError("this is not a mapping", file=path, value=next(iter(table), None), remedy=remedy)
    known = {"topic", "values", "component", "ids", "stamp", "unit", "type"}
    for place, found, keys in (("readings", readings, known), ("joints", joints, {"topic"})):
        if more := found.keys() - keys:
            remedy = f"Allowed keys: {', '.join(sorted(keys))}"
            raise LiveError("unknown key", file=path, place=f"{place}.{min(more)}", remedy=remedy)
    return readings, joints, types


def _stated_ids(readings: Mapping[str, Any], path: Path) -> Any:
    """Return the ids: a tuple, or what is stated instead, which must be the name of a field."""
    ids = readings.get("ids")
    if not isinstance(ids, list):
        return ids
    if not all(isinstance(one, int | str) and not isinstance(one, bool) for one in ids):
        raise LiveError("expected whole numbers, or texts link:id", file=path, place="readings.ids")
    return tuple(ids)


def _check_texts(words: Mapping[str, object], path: Path) -> None:
    """Raise LiveError unless all values are texts; only those of topic and values are required."""
    for place, word in words.items():
        if not isinstance(word, str | None) or (word is None and place in ("readings.topic", "readings.values")):
            raise LiveError("expected a text", file=path, place=place, value=word)


def _stated_unit(readings: Mapping[str, Any], path: Path) -> Unit:
    try:
        return unit_of(readings.get("unit", "counts"))
    except MalformedReadingError as error:
        raise error.at(kind=LiveError, file=path, place="readings.unit") from error


def _stated_component(readings: Mapping[str, Any], path: Path) -> str | None:
    component = readings.get("component")
    if component not in (None, *COMPONENTS):
        remedy = f"Choose one of: {', '.join(COMPONENTS)}"
        raise LiveError("unknown component", file=path, place="readings.component", value=component, remedy=remedy)
    return component


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
            values = self._values(message)
            ids = topics.ids
            if isinstance(ids, str):
                ids = tuple(one for found in _fields(message, ids.split(".")) for one in _list(found))
            at = received
            if topics.stamp is not None:
                (stamp,) = _fields(message, topics.stamp.split("."))
                at = stamp.sec + 1e-9 * stamp.nanosec
        except MalformedReadingError as error:
            raise error.at(place=topic) from error
        except (AttributeError, TypeError, ValueError) as error:
            raise MalformedReadingError(_MISMATCH, place=topic, value=error) from error
        links, labels = (None, None) if ids is None else _labels(ids)
        shear = None
        if topics.component == "xyz":
            shear = values[:, :2]
            values = values[:, 2]
        return Reading(at, values, topics.unit, labels, joints=self.joints, links=links, shear=shear)

    def _values(self, message: Any) -> FloatArray:
        """Return the values (n,) of a message, or with all components (n, 3)."""
        topics = self.topics
        paths = (topics.values,) if isinstance(topics.values, str) else topics.values
        found = [_numbers(value) for path in paths for value in _fields(message, path.split("."))]
        values = np.concatenate([*found, np.empty(0)])
        if topics.component is None:
            return values
        if len(values) % 3:
            remedy = f"With component = {topics.component!r}, the values are x, y and z of each taxel"
            raise MalformedReadingError(_MISMATCH, value=f"{len(values)} numbers", remedy=remedy)
        vectors = values.reshape(-1, 3)
        if topics.component == "norm":
            return np.asarray(np.linalg.norm(vectors, axis=1))
        if topics.component == "xyz":
            return vectors
        return vectors[:, COMPONENTS.index(topics.component)]


def _labels(ids: Sequence[int | str]) -> tuple[tuple[str, ...] | None, IntArray]:
    """Return the links and numbers of ids; numbers alone have no links."""
    numbers = np.asarray(ids)
    if numbers.dtype.kind in "US":
        return labels_of([str(one) for one in ids])
    return None, numbers.astype(np.int64)


def _fields(message: Any, names: Sequence[str]) -> Iterator[Any]:
    """Yield the values at a path; see the module for its parts."""
    if not names:
        yield message
        return
    for one in _part(message, names[0]):
        yield from _fields(one, names[1:])


def _part(message: Any, name: str) -> Sequence[Any]:
    """Return the values of a part of a path: those of a list, or the field of a message.

    Raises:
        MalformedReadingError: The message has no such field, or the list no such entry.
    """
    if isinstance(message, list | np.ndarray):
        key, equals, text = name.partition("=")
        if name == "*":
            return list(message)
        if name.isdecimal() and int(name) < len(message):
            return [message[int(name)]]
        if equals and (found := [one for one in message if str(getattr(one, key, None)) == text]):
            return found
        remedy = f"This is a list of {len(message)}: give *, a position, or FIELD=TEXT"
        raise MalformedReadingError(_MISMATCH, value=name, remedy=remedy)
    if not hasattr(message, name) or name.startswith("_"):
        known = _field_names(message) if is_dataclass(message) else []
        remedy = f"Its fields are: {', '.join(known)}" if known else "This is not a message: end the path before it"
        raise MalformedReadingError(_MISMATCH, value=name, remedy=remedy)
    return [getattr(message, name)]


def _field_names(message: Any) -> list[str]:
    return [one.name for one in fields(message) if not one.name.startswith("_")]


def _list(value: Any) -> Sequence[Any]:
    return list(value) if isinstance(value, list | np.ndarray) else [value]


def _numbers(value: Any) -> FloatArray:
    """Return the numbers of a field in order: a number, an array, or a message such as a vector, or a list of these."""
    if is_dataclass(value):
        return np.concatenate([_numbers(getattr(value, name)) for name in _field_names(value)])
    if isinstance(value, list) and any(map(is_dataclass, value)):
        return np.concatenate([_numbers(one) for one in value])
    return np.asarray(value, dtype=np.float64).reshape(-1)


def import_rosbags() -> Any:
    """Return the optional library ``rosbags``.

    Raises:
        LiveError: It is not installed.
    """
    try:
        import rosbags.highlevel
        import rosbags.typesys
    except ImportError as error:
        raise LiveError("messages of ROS need rosbags", remedy=f"Install it with: {install_line('ros')}") from error
    return rosbags


def message_types(topics: RosTopics) -> Any:
    """Return the types of messages of ``rosbags``: those of ROS 2 Humble and of the mapping.

    Raises:
        LiveError: A definition in the mapping is invalid.
    """
    types = import_rosbags().typesys
    store = types.get_typestore(types.Stores.ROS2_HUMBLE)
    added = dict[str, Any]()
    for name, text in topics.types.items():
        if not re.fullmatch(r"\w+/msg/\w+", name):
            remedy = "Write it as package/msg/Name, in quotes"
            raise LiveError("invalid name of a message type", place=f"types.{name}", remedy=remedy)
        try:
            added |= types.get_types_from_msg(text, name)
        except Exception as error:  # rosbags raises many kinds of errors for invalid text
            remedy = "Give the text of its .msg file"
            raise LiveError("invalid definition of a message type", place=f"types.{name}", remedy=remedy) from error
    try:
        store.register({name: definition for name, definition in added.items() if name not in store.fielddefs})
        for name in added:
            store.generate_msgdef(name)  # raises for a type that it names and that is missing
    except Exception as error:  # as above
        remedy = "Add every type that a definition names, or leave out those of ROS 2 Humble"
        raise LiveError(
            "the definitions of message types do not fit", place="types", value=error, remedy=remedy
        ) from error
    return store


def read_bag(path: Path, topics: RosTopics) -> Iterator[Item]:
    """Yield the readings of a bag: a folder recorded by ROS 2, or its MCAP or SQLite file.

    Raises:
        LiveError: It cannot be read, or does not contain the topic.
    """
    rosbags = import_rosbags()
    store = message_types(topics)
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
        LiveError: The mapping has no type, or ROS 2 is not installed.
    """

    finite = False
    slow = True

    def __init__(self, topics: RosTopics) -> None:
        if topics.type is None:
            remedy = 'Add the type to [readings], for example type = "std_msgs/msg/Float32MultiArray"'
            raise LiveError("the mapping does not state the type of the messages", place="readings.type", remedy=remedy)
        if find_spec("rclpy") is None:  # attempts to connect would repeat it for ever
            remedy = "Install ROS 2 and source its setup file before starting, or play a bag of the topic"
            raise LiveError("ROS 2 is not installed", place="rclpy", remedy=remedy)
        self.address = f"ros2:{topics.topic}"
        self._topics = topics
        self._reader = MessageReader(topics)
        self._node: Any = None
        self._context: Any = None
        self._rclpy: Any = None
        self._arrived: deque[tuple[str, bytes]] = deque()

    def open(self) -> None:
        """Subscribe; raises LiveError if ROS 2 cannot be imported or does not know the type."""
        try:
            import rclpy  # type: ignore[import-not-found,unused-ignore]
            from rosidl_runtime_py.utilities import get_message  # type: ignore[import-not-found,unused-ignore]
        except ImportError as error:
            remedy = "Source the setup file of ROS 2 before starting"
            raise LiveError("ROS 2 cannot be imported", value=error, remedy=remedy) from error
        self._store = message_types(self._topics)
        if self._topics.type not in self._store.fielddefs:
            remedy = "Add its definition to [types]: the text of its .msg file"
            raise LiveError("unknown type of messages", place="readings.type", value=self._topics.type, remedy=remedy)
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
