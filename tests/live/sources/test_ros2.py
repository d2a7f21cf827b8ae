"""ROS 2 messages as the bytes that ROS 2 sends (CDR), written by ``rosbags``: no ROS was run."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError, UsageError
from tactile_maps.live.readings.readings import MalformedReadingError, Unit
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.sources.open import SourceOptions, open_source
from tactile_maps.live.sources.ros2 import MessageReader, Ros2Source, RosTopics, load_topics

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
def test_a_bag_is_played_with_its_joints(tmp_path, storage):
    write_bag(tmp_path / "bag", rosbags.StoragePlugin[storage])
    (tmp_path / "map.toml").write_text(MAPPING)
    options = SourceOptions(mapping=tmp_path / "map.toml", speed=None)
    for address in (tmp_path / "bag", next(p for p in (tmp_path / "bag").iterdir() if p.suffix in (".mcap", ".db3"))):
        connection = Connection(open_source(str(address), options))
        connection.open()
        while connection.status.state != "ended":
            connection.step(0.0)
        found = [connection.take().reading for _ in range(2)]
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


def test_fields_may_be_nested_and_the_stamp_is_the_time():
    reader = MessageReader(RosTopics("/skin", "position", stamp="header.stamp"))
    reading = reader.read("/skin", STORE.deserialize_cdr(STORE.serialize_cdr(joints(a=1.0), JOINTS), JOINTS), 99.0)
    assert (reading.time, reading.values.tolist()) == (3.000000005, [1.0])
    with pytest.raises(MalformedReadingError, match="not match the mapping"):
        MessageReader(RosTopics("/skin", "pressures")).read("/skin", array([1]), 0.0)


def test_a_topic_that_is_not_there_and_a_bag_that_is_none(tmp_path):
    write_bag(tmp_path / "bag", rosbags.StoragePlugin.MCAP)
    mapping = tmp_path / "map.toml"
    mapping.write_text(MAPPING.replace("/skin", "/fur"))
    with pytest.raises(LiveError, match="Its topics are: /joint_states, /skin"):
        open_source(str(tmp_path / "bag"), SourceOptions(mapping=mapping)).open()
    (tmp_path / "none").mkdir()
    with pytest.raises(LiveError, match="the bag cannot be read"):
        open_source(str(tmp_path / "none"), SourceOptions(mapping=mapping)).open()
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
        ("[readings]\ntopic = '/a'\nvalues = 'data'\n[fur]\n", "not a mapping .found: fur"),
        ("[readings", "not TOML"),
    ],
)
def test_a_mistake_in_the_mapping_is_named(tmp_path, text, said):
    path = tmp_path / "map.toml"
    path.write_text(text)
    with pytest.raises(LiveError, match=said):
        load_topics(path)


def test_live_the_type_must_be_named_and_ros_be_there():
    with pytest.raises(LiveError, match="does not state the type"):
        Ros2Source(RosTopics("/skin", "data"))
    try:
        import rclpy  # noqa: F401
    except ImportError:
        with pytest.raises(LiveError, match="ROS 2 is not installed"):
            Ros2Source(RosTopics("/skin", "data", type=ARRAY)).open()


def test_values_of_several_fields_and_of_a_list_of_messages_are_joined():
    message = SimpleNamespace(parts=[SimpleNamespace(values=[1, 2]), SimpleNamespace(values=[3])], fx=4.0)
    assert MessageReader(RosTopics("/skin", "parts.*.values")).read("/skin", message, 0.0).values.tolist() == [1, 2, 3]
    several = MessageReader(RosTopics("/skin", ("fx", "parts.*.values"))).read("/skin", message, 0.0)
    assert several.values.tolist() == [4, 1, 2, 3]


@pytest.mark.parametrize("values", ["[]", "[1]", "3"])
def test_fields_that_are_no_texts_are_refused(values, tmp_path):
    path = tmp_path / "mapping.toml"
    path.write_text(f"[readings]\ntopic = '/skin'\nvalues = {values}\n")
    with pytest.raises(LiveError, match="readings.values: expected"):
        load_topics(path)
    path.write_text("[readings]\ntopic = '/skin'\nvalues = ['fx', 'parts.*.values']\n")
    assert load_topics(path).values == ("fx", "parts.*.values")
