"""The bag reads back with the rosbags library: every tick's joints and pressures, pictures at their rate."""

from __future__ import annotations

from collections import defaultdict

import numpy as np
import pytest

from app.export.export import ExportOptions, export_recording

rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="rosbags is not installed (extra export)")


@pytest.fixture(scope="module")
def told(player, tmp_path_factory):
    from rosbags.typesys import Stores, get_typestore

    folder = tmp_path_factory.mktemp("bag") / "bag"
    export_recording(player, folder, to="rosbag2", options=ExportOptions(rate=20.0))
    types, found = get_typestore(Stores.ROS2_HUMBLE), defaultdict(list)
    with rosbag2.Reader(folder) as reader:
        for connection, time, data in reader.messages():
            found[connection.topic].append((time, types.deserialize_cdr(data, connection.msgtype)))
    return found


def test_every_tick_has_its_joints_and_pressures(told, frames, player):
    assert len(told["/joint_states"]) == len(told["/skin/pressures"]) == len(frames)
    for (time, joints), (_, pressures), frame in zip(
        told["/joint_states"], told["/skin/pressures"], frames, strict=True
    ):
        np.testing.assert_array_equal(joints.position, frame.posture)
        np.testing.assert_array_equal(pressures.data, frame.pressures.astype(np.float32))
        assert time == int(player.versions["started_ns"]) + round(1e9 * frame.tick * player.prepared.scene.tick)


def test_pictures_come_at_their_rate(told, player, frames):
    count = sum(frame.tick % 10 == 0 for frame in frames)
    topics = [f"/taxels/{patch.link}" for patch in player.prepared.skin.patches]
    for topic in ("/tf", "/tactile_image", "/contacts", *topics):
        assert len(told[topic]) == count
    assert [message.data for _, message in told["/events"]] == [event.words for event in player.events]


def test_markers_point_at_the_contacts(told, frames):
    shown = [frame for frame in frames if frame.tick % 10 == 0]
    for (_, message), frame in zip(told["/contacts"], shown, strict=True):
        arrows = message.markers[1:]
        assert [arrow.id for arrow in arrows] == [region.id for region in frame.regions]
        for arrow, region in zip(arrows, frame.regions, strict=True):
            end = arrow.points[1]
            np.testing.assert_allclose([end.x, end.y, end.z], region.link_position)
    assert any(frame.regions for frame in shown)
