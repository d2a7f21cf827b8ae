"""Viewers of other programs find what they know in a recording: read back by the MCAP library's own decoders."""

from __future__ import annotations

import subprocess
import sys
from collections import defaultdict

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from tactile_maps.core.errors import SimulationError
from tactile_maps.recording.encoding.viewer_messages import RATE, ViewerMessages, viewer_schemas
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.recording.verify import verify
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Failure
from tactile_maps.session.session import Session

STARTED = 1_700_000_000_000_000_000


@pytest.fixture(scope="module")
def player(recording):
    return RecordingPlayer(recording)


@pytest.fixture(scope="module")
def by_topic(recording):
    """(time [ns], message) by topic, read with a decoder that only knows the file's own schemas."""
    found = decoded(recording)
    assert all(message.data for _, message in found["/frame"]), "our own topic: other decoders see only bytes"
    return {topic: messages for topic, messages in found.items() if topic != "/frame"}


def decoded(path):
    found = defaultdict(list)
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        topics = [
            channel.topic
            for channel in reader.get_summary().channels.values()
            if channel.message_encoding == "protobuf"
        ]
        for _, channel, message, content in reader.iter_decoded_messages(topics=topics):
            found[channel.topic].append((message.log_time, content))
    return found


def nearest(player, time, start):
    """The recorded frame of a message."""
    tick = round(1e-9 * (time - start) / player.prepared.scene.tick)
    return next(frame for frame in player if frame.tick == tick)


def start_of(player):
    return int(player.versions["started_ns"])


def test_every_topic_is_present_at_its_stated_rate(by_topic, player):
    assert set(by_topic) == set(viewer_schemas(player.prepared))
    assert len(by_topic["/robot"]) == 1
    for topic in set(by_topic) - {"/robot", "/events"}:
        assert len(by_topic[topic]) == pytest.approx(RATE * player.duration, abs=2), topic


def test_times_are_wall_clock_times(by_topic, player, recording):
    """Times start when the recording began and advance by simulated time."""
    assert abs(1e-9 * start_of(player) - recording.stat().st_mtime) < 600
    frame = nearest(player, by_topic["/tf"][3][0], start_of(player))
    at = start_of(player) + round(1e9 * frame.time)
    assert abs(by_topic["/tf"][3][0] - at) <= 1
    stamp = by_topic["/tactile_image"][3][1].timestamp
    assert stamp.seconds * 10**9 + stamp.nanos == by_topic["/tactile_image"][3][0]


def test_clouds_contain_every_taxel_with_its_pressure_in_link_coordinates(by_topic, player):
    skin = player.prepared.skin
    seen = []
    for topic, messages in by_topic.items():
        if not topic.startswith("/taxels/"):
            continue
        time, cloud = messages[len(messages) // 2]
        names = [field.name for field in cloud.fields]
        kinds = [(name, "<u4" if name == "taxel" else "<f4") for name in names]
        points = np.frombuffer(cloud.data, np.dtype(kinds))
        assert [field.offset for field in cloud.fields] == [4 * place for place in range(len(names))]
        assert cloud.point_stride == points.itemsize
        frame = nearest(player, time, start_of(player))
        np.testing.assert_array_equal(points["pressure"], (1e-3 * frame.pressures[points["taxel"]]).astype(np.float32))
        for point in points[::10]:
            at = skin.taxel_point(int(point["taxel"]))
            assert skin.link(at) == cloud.frame_id == topic.removeprefix("/taxels/")
            np.testing.assert_allclose([point[axis] for axis in "xyz"], skin.position(at), atol=1e-5)
        seen += points["taxel"].tolist()
    assert sorted(seen) == list(range(len(skin)))


def test_links_have_the_poses_of_the_posture(by_topic, player):
    time, message = by_topic["/tf"][-1]
    configuration = Configuration(player.prepared.robot)
    configuration.update(nearest(player, time, start_of(player)).posture)
    assert {one.child_frame_id for one in message.transforms} >= {link.name for link in player.prepared.robot.links}
    for one in message.transforms[: len(player.prepared.robot.links)]:
        pose = configuration.pose(one.child_frame_id)
        np.testing.assert_allclose(
            [one.translation.x, one.translation.y, one.translation.z], pose.translation, atol=1e-12
        )
        turn = Rotation.from_quat([one.rotation.x, one.rotation.y, one.rotation.z, one.rotation.w])
        np.testing.assert_allclose(turn.as_matrix(), pose.rotation, atol=1e-9)


@pytest.mark.long
def test_contacts_point_into_the_skin_and_disappear_when_lost(by_topic, player):
    touched = 0
    for time, update in by_topic["/contacts"]:
        frame = nearest(player, time, start_of(player))
        assert len(update.deletions) == 1
        assert [entity.id for entity in update.entities] == [f"contact {region.id}" for region in frame.regions]
        for entity, region in zip(update.entities, frame.regions, strict=True):
            arrow = entity.arrows[0].pose
            turn = Rotation.from_quat([getattr(arrow.orientation, axis) for axis in "xyzw"])
            np.testing.assert_allclose(turn.apply([1.0, 0.0, 0.0]), -region.link_normal, atol=1e-9)
            length = entity.arrows[0].shaft_length + entity.arrows[0].head_length
            tip = np.array([getattr(arrow.position, axis) for axis in "xyz"]) - length * region.link_normal
            np.testing.assert_allclose(tip, region.link_position, atol=1e-9)
            assert entity.texts[0].text == f"{region.force:.2f} N"
            assert entity.frame_id == region.link
            touched += 1
    assert touched


def test_images_events_joints_and_surfaces_are_written(by_topic, player):
    image = by_topic["/tactile_image"][-1][1]
    assert (image.encoding, image.step, len(image.data)) == ("rgb8", 3 * image.width, image.step * image.height)
    texts = [message.message for _, message in by_topic["/events"]]
    assert [event.words for event in player.events] == [text for text in texts if not text.startswith("colours")]
    assert sum(text.startswith("colours") for text in texts) >= 1
    time, joints = by_topic["/joint_states"][5]
    frame = nearest(player, time, start_of(player))
    assert [joint.position for joint in joints.joints] == frame.posture.tolist()
    surfaces = {entity.id: len(entity.triangles[0].indices) // 3 for entity in by_topic["/robot"][0][1].entities}
    robot = player.prepared.robot
    assert surfaces.items() >= {link.name: len(link.mesh.faces) for link in robot.links if link.mesh}.items()


@pytest.mark.long
def test_recording_without_viewer_messages_replays_identically(prepared, tmp_path):
    def record(path, **more):
        session = Session(prepared)
        with Recorder(prepared, path, started=STARTED, **more) as recorder:
            for _ in range(30):
                recorder.write(session.tick(), session.inputs)
        return path

    shown = record(tmp_path / "shown.mcap")
    bare = record(tmp_path / "bare.mcap", viewers=False)
    assert bare.stat().st_size < shown.stat().st_size
    assert set(decoded(bare)) == {"/frame"}
    for path in (shown, bare):
        assert verify(RecordingPlayer(path)).identical
    pairs = zip(RecordingPlayer(shown), RecordingPlayer(bare), strict=True)
    assert all(np.array_equal(a.pressures, b.pressures) and np.array_equal(a.posture, b.posture) for a, b in pairs)


def test_recovered_recording_keeps_viewer_messages(recording, tmp_path, by_topic):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording.read_bytes()[:-20_000])
    recover(cut, tmp_path / "whole.mcap")
    kept = decoded(tmp_path / "whole.mcap")
    assert set(kept) == {*by_topic, "/frame"}
    assert [str(one) for one in kept["/tf"]] == [str(one) for one in by_topic["/tf"][: len(kept["/tf"])]]


def test_failure_is_reported_as_fatal(prepared):
    session = Session(prepared)
    failure = Failure(7, SimulationError("the physics gave up"), (), session.frame)
    ((topic, data),) = ViewerMessages(prepared, started=STARTED).of_failure(failure)
    assert topic == "/events"
    assert b"the physics gave up" in data


def test_rerun_can_convert_the_recording(recording, tmp_path):
    """Rerun's own converter finds an image and points. Needs rerun-sdk (extra ``rerun``), 170 MB."""
    pytest.importorskip("rerun", reason="rerun-sdk is not installed (extra rerun)")
    target = tmp_path / "demo.rrd"
    call = [sys.executable, "-m", "rerun", "mcap", "convert", str(recording), "-o", str(target)]
    subprocess.run(call, check=True, capture_output=True, timeout=120)
    printed = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "print", "-vv", str(target)],
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    )
    text = printed.stdout + printed.stderr
    assert "Image:" in text
    assert "Points3D:" in text
