"""The bag reads back with the rosbags library: every tick's joints and pressures, pictures at their rate."""

from __future__ import annotations

import json
from collections import defaultdict

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from tactile_maps.export.contact_messages import contact_wrench, outline
from tactile_maps.export.export import ExportOptions, export_recording
from tactile_maps.export.tables import taxel_labels
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.robots.kinematics import Configuration

rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed (extra export)")


def exported(player, folder, rate):
    export_recording(player, folder, to="rosbag2", options=ExportOptions(rate=rate))
    return folder


@pytest.fixture(scope="module")
def bag(player, tmp_path_factory):
    return exported(player, tmp_path_factory.mktemp("bag") / "bag", 20.0)


@pytest.fixture(scope="module")
def by_topic(bag):
    return messages(bag)


def messages(folder):
    """(time [ns], message) by topic; our own types by the definitions in the bag."""
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    types = get_typestore(Stores.ROS2_HUMBLE)
    found = defaultdict(list)
    with rosbag2.Reader(folder) as reader:
        for connection in reader.connections:
            if connection.msgtype not in types.types:
                types.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection, time, data in reader.messages():
            found[connection.topic].append((time, types.deserialize_cdr(data, connection.msgtype)))
    return found


def test_files_have_their_final_names(bag, path):
    assert sorted(file.name for file in bag.iterdir()) == [f"{path.stem}.mcap", "metadata.yaml"]
    metadata = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    assert metadata["relative_file_paths"] == [f"{path.stem}.mcap"]
    assert [file["path"] for file in metadata["files"]] == [f"{path.stem}.mcap"]


def test_labels_are_latched_for_late_subscribers(bag, by_topic, player):
    with rosbag2.Reader(bag) as reader:
        offered = {one.topic: one.ext.offered_qos_profiles for one in reader.connections}
    (profile,) = offered.pop("/skin/taxels")
    assert (profile.durability.name, profile.reliability.name, profile.history.name, profile.depth) == (
        "TRANSIENT_LOCAL",
        "RELIABLE",
        "KEEP_LAST",
        1,
    )
    assert not any(offered.values())
    ((_, labels),) = by_topic["/skin/taxels"]
    assert json.loads(labels.data) == taxel_labels(player.prepared.skin)


def test_every_tick_has_its_joints_and_pressures(by_topic, frames, player):
    assert len(by_topic["/joint_states"]) == len(by_topic["/skin/pressures"]) == len(frames)
    for (time, joints), (_, pressures), frame in zip(
        by_topic["/joint_states"], by_topic["/skin/pressures"], frames, strict=True
    ):
        assert joints.name == [joint.name for joint in player.prepared.robot.joints]
        np.testing.assert_array_equal(joints.position, frame.posture)
        np.testing.assert_array_equal(joints.velocity, frame.velocity)
        assert joints.effort.size == 0, "torques are not measured"
        np.testing.assert_array_equal(pressures.data, frame.pressures.astype(np.float32))
        assert time == int(player.versions["started_ns"]) + round(1e9 * frame.tick * player.prepared.scene.tick)


def test_images_have_the_requested_rate(by_topic, player, frames):
    count = sum(frame.tick % 10 == 0 for frame in frames)
    topics = [f"/taxels/{patch.link}" for patch in player.prepared.skin.patches]
    for topic in ("/tf", "/tactile_image", "/contacts", *topics):
        assert len(by_topic[topic]) == count
    assert [message.data for _, message in by_topic["/events"]] == [event.words for event in player.events]


def test_clouds_state_the_layout_of_their_points(by_topic, player):
    for patch in player.prepared.skin.patches:
        _, cloud = by_topic[f"/taxels/{patch.link}"][0]
        assert cloud.point_step == 4 * len(cloud.fields)
        assert len(cloud.data) == cloud.row_step == cloud.width * cloud.point_step


def test_markers_point_at_the_contacts(by_topic, frames):
    shown = [frame for frame in frames if frame.tick % 10 == 0]
    for (_, message), frame in zip(by_topic["/contacts"], shown, strict=True):
        arrows = message.markers[1:]
        assert [arrow.id for arrow in arrows] == [region.id for region in frame.regions]
        for arrow, region in zip(arrows, frame.regions, strict=True):
            end = arrow.points[1]
            np.testing.assert_allclose([end.x, end.y, end.z], region.link_position)
    assert any(frame.regions for frame in shown)


def test_contacts_have_outline_wrench_and_covariance_for_each_link(by_topic, frames, player):
    assert len(by_topic["/skin/contacts"]) == len(frames)
    for (_, message), frame in zip(by_topic["/skin/contacts"], frames, strict=True):
        assert [one.id for one in message.contacts] == [region.id for region in frame.regions]
        for one, region in zip(message.contacts, frame.regions, strict=True):
            expected = contact_wrench(region)
            force = one.wrench.force
            np.testing.assert_allclose([force.x, force.y, force.z], -region.force * region.link_normal, atol=1e-12)
            np.testing.assert_array_equal(one.covariance.reshape(6, 6), expected.covariance)
            corners = [[p.x, p.y, p.z] for p in one.region.points]
            np.testing.assert_allclose(corners, outline(region, frame, player.prepared.skin), atol=1e-6)
        assert {one.link for one in message.links} == {region.link for region in frame.regions}
    assert any(frame.regions for frame in frames)


@pytest.mark.parametrize("rate", [pytest.param(20.0, marks=pytest.mark.long), 30.0])
def test_images_have_the_times_of_their_ticks(player, frames, tmp_path, rate):
    """A rate of 30 Hz at 200 ticks per second shows every seventh tick."""
    found = messages(exported(player, tmp_path / "bag", rate))
    tick = player.prepared.scene.tick
    started = int(player.versions["started_ns"])
    every = round(1 / (rate * tick))
    times = [started + round(1e9 * frame.tick * tick) for frame in frames if frame.tick % every == 0]
    assert len(times) > 10
    for topic in ("/tf", "/tactile_image", "/contacts", f"/taxels/{player.prepared.skin.patches[0].link}"):
        assert [time for time, _ in found[topic]] == times
    stamps = [message.header.stamp for _, message in found["/tactile_image"]]
    assert [10**9 * stamp.sec + stamp.nanosec for stamp in stamps] == times


def test_images_show_their_ticks(by_topic, player, frames):
    image = TactileImage(player.prepared.map, width=128)
    shown = [frame for frame in frames if frame.tick % 10 == 0]
    assert any(frame.pressures.max() > 1e3 for frame in shown)
    for (_, message), frame in zip(by_topic["/tactile_image"], shown, strict=True):
        values = message.data.view(np.float32).reshape(message.height, message.width)
        np.testing.assert_array_equal(values, image.render(frame.pressures))


def test_transforms_equal_the_poses_of_the_links(by_topic, player, frames):
    configuration = Configuration(player.prepared.robot)
    links = player.prepared.robot.links
    shown = [frame for frame in frames if frame.tick % 10 == 0]
    turned = 0.0
    for (_, message), frame in zip(by_topic["/tf"], shown, strict=True):
        configuration.update(frame.posture)
        for one, link in zip(message.transforms, links, strict=False):
            pose = configuration.pose(link.name)
            turn = one.transform.rotation
            assert one.child_frame_id == link.name
            place = one.transform.translation
            np.testing.assert_allclose([place.x, place.y, place.z], pose.translation, atol=1e-12)
            rotation = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
            np.testing.assert_allclose(rotation, pose.rotation, atol=1e-9)
            turned = max(turned, abs(turn.x), abs(turn.y), abs(turn.z))
    assert turned > 0.1, "some link is turned"
