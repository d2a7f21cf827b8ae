"""ROS 2 messages as the bytes that ROS 2 sends (CDR), written by ``rosbags``: no ROS was run."""

from __future__ import annotations

import sqlite3
import textwrap
from contextlib import closing
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest

from tactile_maps.core.assets import asset
from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError, Unit
from tactile_maps.live.session.connection import Connection, ConnectionState
from tactile_maps.live.sources.open import SourceOptions, open_source
from tactile_maps.live.sources.ros2 import MessageReader, Ros2Source, RosTopics, load_topics, message_types

rosbags = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")
STORE = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
ARRAY = "std_msgs/msg/Float32MultiArray"
JOINTS = "sensor_msgs/msg/JointState"
IMAGE = "sensor_msgs/msg/Image"
MAPPING = """
[readings]
topic = "/skin"
values = "data"
ids = [5, 9, 7]
unit = "kPa"
[joints]
topic = "/joint_states"
"""


def array(values):
    kinds = STORE.types
    layout = kinds["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
    return kinds[ARRAY](layout=layout, data=np.array(values, dtype=np.float32))


def joints(**positions):
    kinds = STORE.types
    header = kinds["std_msgs/msg/Header"](stamp=kinds["builtin_interfaces/msg/Time"](sec=3, nanosec=5), frame_id="")
    values = np.array(list(positions.values()))
    return kinds[JOINTS](header=header, name=list(positions), position=values, velocity=values, effort=values)


def write_bag(path, storage):
    with rosbags.Writer(path, version=9, storage_plugin=storage) as bag:
        skin = bag.add_connection("/skin", ARRAY, typestore=STORE)
        arm = bag.add_connection("/joint_states", JOINTS, typestore=STORE)
        bag.write(arm, 0, STORE.serialize_cdr(joints(elbow=0.5), JOINTS))
        for number in range(3):
            data = STORE.serialize_cdr(array([number, 1, 2][: 3 - number // 2]), ARRAY)
            bag.write(skin, 10_000_000 * (number + 1), data)


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_bag_is_played_including_joints(tmp_path, storage):
    write_bag(tmp_path / "bag", rosbags.StoragePlugin[storage])
    (tmp_path / "map.toml").write_text(MAPPING)
    options = SourceOptions(mapping=tmp_path / "map.toml", speed=None)
    for address in (tmp_path / "bag", next(p for p in (tmp_path / "bag").iterdir() if p.suffix in (".mcap", ".db3"))):
        connection = Connection(open_source(str(address), options))
        connection.open()
        found = []
        while connection.status.state is not ConnectionState.ENDED:
            connection.step(0.0)
            found += [taken.reading] if (taken := connection.take()) else []
        assert [one.time for one in found] == [0.01, 0.02]
        assert found[1].values.tolist() == [1.0, 1.0, 2.0]
        assert found[1].ids.tolist() == [5, 9, 7]
        assert (found[1].unit, dict(found[1].joints)) == (Unit.KILOPASCAL, {"elbow": 0.5})
        assert connection.status.counts.malformed == 1  # the last has two values for three ids


def test_ids_of_a_mapping_may_state_their_link(tmp_path):
    path = tmp_path / "map.toml"
    path.write_text('[readings]\ntopic = "/skin"\nvalues = "data"\nids = ["l_hand:3", "r_hand:3"]\n')
    reading = MessageReader(load_topics(path)).read("/skin", array([1, 2]), 0.0)
    assert (reading.ids.tolist(), reading.links) == ([3, 3], ("l_hand", "r_hand"))


def test_nested_fields_are_read_and_the_stamp_is_the_time():
    reader = MessageReader(RosTopics("/skin", "position", stamp="header.stamp"))
    reading = reader.read("/skin", STORE.deserialize_cdr(STORE.serialize_cdr(joints(a=1.0), JOINTS), JOINTS), 99.0)
    assert (reading.time, reading.values.tolist()) == (3.000000005, [1.0])
    with pytest.raises(MalformedReadingError, match="not match the mapping"):
        MessageReader(RosTopics("/skin", "pressures")).read("/skin", array([1]), 0.0)


def test_missing_topic_and_invalid_bag_are_rejected(tmp_path):
    write_bag(tmp_path / "bag", rosbags.StoragePlugin.MCAP)
    mapping = tmp_path / "map.toml"
    mapping.write_text(MAPPING.replace("/skin", "/fur"))
    with pytest.raises(LiveError, match="Its topics are: /joint_states, /skin"):
        open_source(str(tmp_path / "bag"), SourceOptions(mapping=mapping)).open()
    (tmp_path / "bag" / "metadata.yaml").write_text("none")
    with pytest.raises(LiveError, match="the bag cannot be read"):
        open_source(str(tmp_path / "bag"), SourceOptions(mapping=mapping)).open()
    with pytest.raises(UsageError, match="need a mapping"):
        open_source(str(tmp_path / "bag"))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not a mapping"),
        ("[readings]\ntopic = '/a'", "readings.values: expected a text"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\nfield = 'x'", "readings.field: unknown key"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\nids = [1.5]", "readings.ids: expected whole numbers"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\nids = 3", "readings.ids: expected a text"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\nunit = 'psi'", "readings.unit: unknown unit"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\ncomponent = 'w'", "readings.component: unknown component"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\n[types]\n'a/msg/B' = 3", "types.a/msg/B: expected a text"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\n[types]\nB = 'int8 a'", "types.B: invalid name"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\n[types]\n'a/msg/B' = '?'", "types.a/msg/B: invalid definition"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\n[types]\n'a/msg/B' = 'a/C c'", "types: .* do not fit"),
        ("[readings]\ntopic = '/a'\nvalues = 'data'\n[fur]\n", "not a mapping .found: fur"),
        ("[readings", "not TOML"),
    ],
)
def test_invalid_mapping_entry_is_reported(tmp_path, text, said):
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(LiveError, match=said):
        load_topics(path)


def test_live_topics_require_a_type_and_an_installed_ros():
    with pytest.raises(LiveError, match="does not state the type"):
        Ros2Source(RosTopics("/skin", "data"))
    if find_spec("rclpy") is None:
        with pytest.raises(LiveError, match="ROS 2 is not installed"):
            Ros2Source(RosTopics("/skin", "data", type=ARRAY))


def test_values_of_several_fields_and_of_a_list_of_messages_are_joined():
    message = SimpleNamespace(parts=[SimpleNamespace(values=[1, 2]), SimpleNamespace(values=[3])], fx=4.0)
    assert MessageReader(RosTopics("/skin", "parts.*.values")).read("/skin", message, 0.0).values.tolist() == [1, 2, 3]
    several = MessageReader(RosTopics("/skin", ("fx", "parts.*.values"))).read("/skin", message, 0.0)
    assert several.values.tolist() == [4, 1, 2, 3]


@pytest.mark.parametrize("values", ["[]", "[1]", "3"])
def test_fields_that_are_not_text_are_rejected(values, tmp_path):
    path = tmp_path / "mapping.toml"
    path.write_text(f"[readings]\ntopic = '/skin'\nvalues = {values}\n")
    with pytest.raises(LiveError, match="readings.values: expected"):
        load_topics(path)
    path.write_text("[readings]\ntopic = '/skin'\nvalues = ['fx', 'parts.*.values']\n")
    assert load_topics(path).values == ("fx", "parts.*.values")


def build(store, kind, **values):
    """Return a message with these fields, and zeros or empty texts and lists in all others."""
    zeros = {"string": "", "bool": False}

    def field_value(name, node):
        if name in values:
            return values[name]
        what, detail = node
        if what.name == "BASE":
            return zeros.get(detail[0], 0)
        return build(store, detail) if what.name == "NAME" else []

    return store.types[kind](**{name: field_value(name, node) for name, node in store.fielddefs[kind][1]})


def vector(store, *xyz):
    return build(store, "geometry_msgs/msg/Vector3", **dict(zip("xyz", map(float, xyz), strict=True)))


def tactile_state(store):
    kind = "sensor_msgs/msg/ChannelFloat32"
    arrays = {"thumb": [1, 2], "palm": [3, np.nan, 5]}
    return {"sensors": [build(store, kind, name=n, values=np.array(a, np.float32)) for n, a in arrays.items()]}


def papillarray(store):
    kind = "papillarray_ros2_v2/msg/PillarState"
    return {"pillars": [build(store, kind, id=n, f_x=9.0, f_z=0.5 * n) for n in (7, 3)], "gf_z": 5.0}


def wuji(store):
    return {"pressure": np.where(np.arange(768) % 32 < 3, np.nan, 0.25).astype(np.float32), "sequence": 3}


def paxini(store):
    kind = "paxini_hardware/msg/TactileTaxel"
    forces = [(3, 0, 4), (np.nan, 0, 1), (0, 0, -2)]
    return {"taxels": [build(store, kind, index=5 + n, force=vector(store, *f)) for n, f in enumerate(forces)]}


VENDORS = {
    "tactile_msgs/msg/TactileState": (tactile_state, None, [1, 2, 3, np.nan, 5]),
    "papillarray_ros2_v2/msg/SensorState": (papillarray, [7, 3], [3.5, 1.5]),
    "wujihand_tactile_msgs/msg/TactileFrame": (wuji, None, ([np.nan] * 3 + [0.25] * 29) * 24),
    "paxini_hardware/msg/TactileSensor": (paxini, [5, 6, 7], [5, np.nan, 2]),
}


def guide_mapping(kind):
    """Return the mapping of a type of message that is printed in the guide."""
    page = asset("guide/live.md").read_text(encoding="utf8")
    start = page.rindex("    [readings]", 0, page.index(f'    type = "{kind}"'))
    block = page[start:].split("\n\n")
    return textwrap.dedent("\n".join(part for part in block[:2]))


@pytest.mark.parametrize("kind", VENDORS)
def test_mapping_in_the_guide_reads_encoded_messages(kind, tmp_path):
    make, ids, values = VENDORS[kind]
    path = tmp_path / "map.toml"
    path.write_text(guide_mapping(kind))
    topics = load_topics(path)
    store = message_types(topics)
    stamp = build(store, "builtin_interfaces/msg/Time", sec=3, nanosec=500_000_000)
    header = build(store, "std_msgs/msg/Header", stamp=stamp)
    message = store.serialize_cdr(build(store, kind, header=header, **make(store)), kind)
    reading = MessageReader(topics).read(topics.topic, store.deserialize_cdr(bytes(message), kind), 99.0)
    assert np.array_equal(reading.values, values, equal_nan=True)
    assert (reading.time, None if reading.ids is None else reading.ids.tolist()) == (3.5, ids)


def test_bag_without_definitions_is_read_by_the_types_of_the_mapping(tmp_path):
    kind = "wujihand_tactile_msgs/msg/TactileFrame"
    (tmp_path / "map.toml").write_text(guide_mapping(kind))
    topics = load_topics(tmp_path / "map.toml")
    store = message_types(topics)
    with rosbags.Writer(tmp_path / "bag", version=8, storage_plugin=rosbags.StoragePlugin.SQLITE3) as bag:
        connection = bag.add_connection(topics.topic, kind, typestore=store)
        bag.write(connection, 0, store.serialize_cdr(build(store, kind, **wuji(store)), kind))
    with closing(sqlite3.connect(tmp_path / "bag" / "bag.db3")) as database, database:
        assert database.execute("DELETE FROM message_definitions").rowcount > 0
    source = open_source(str(tmp_path / "bag"), SourceOptions(mapping=tmp_path / "map.toml", speed=None))
    source.open()
    assert np.isnan(source.receive(0.0).values).sum() == 3 * 24


def test_part_of_a_list_is_chosen_by_position_or_name():
    message = SimpleNamespace(parts=[SimpleNamespace(name="a", values=[1, 2]), SimpleNamespace(name="b", values=[3])])
    for part, values in (("1", [3]), ("name=a", [1, 2])):
        reading = MessageReader(RosTopics("/skin", f"parts.{part}.values")).read("/skin", message, 0.0)
        assert reading.values.tolist() == values
    for part in ("2", "name=c", "values"):
        with pytest.raises(MalformedReadingError, match=f"{part}.*list of 2: give"):
            MessageReader(RosTopics("/skin", f"parts.{part}.values")).read("/skin", message, 0.0)


def test_unknown_field_is_reported_with_the_fields_of_the_message():
    with pytest.raises(MalformedReadingError, match="/skin.*found: date.*Its fields are: layout, data"):
        MessageReader(RosTopics("/skin", "date")).read("/skin", array([1]), 0.0)
    with pytest.raises(MalformedReadingError, match="4 numbers.*x, y and z of each"):
        MessageReader(RosTopics("/skin", "data", component="z")).read("/skin", array([1, 2, 3, 4]), 0.0)
