"""A recording holds all it needs, and a hostile one is refused by name."""

from __future__ import annotations

import io
import json
import tracemalloc
import zipfile
import zlib
from dataclasses import replace

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from mcap.writer import CompressionType, IndexType, Writer

from tactile_maps.core.errors import Finding, RecordingError
from tactile_maps.core.files import pack_array, pack_arrays
from tactile_maps.recording.file.mcap_file import MAX_CHUNK, begin_recording, chunk_messages, read_recording
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.recording.recover import recover
from tactile_maps.robots.formats.mjcf import load_mjcf
from tactile_maps.robots.model.robot import Joint
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.session.bundle import objects_from_bytes, objects_to_bytes, robot_from_zip, robot_to_zip
from tactile_maps.session.inputs import EffectsChanged
from tactile_maps.session.session import Session
from tactile_maps.skin.model.skin import TaxelIdentity
from tests.support.recordings import record
from tests.support.touch import bar

BALL = ObjectSpec("ball", "sphere", size=(0.05,))
BALL_BODY = SceneObject(BALL, primitive_mesh(BALL))


def test_recording_contains_scene_robot_map_inputs_and_frames(recording, prepared):
    player = RecordingPlayer(recording)
    assert player.complete
    assert len(player) == 200
    assert player.duration == pytest.approx(199 * prepared.scene.tick)
    assert player.prepared.scene == prepared.scene
    assert player.prepared.robot.mjcf == prepared.robot.mjcf
    assert player.prepared.robot.assets == prepared.robot.assets
    assert np.array_equal(player.prepared.map.taxel_points, prepared.map.taxel_points)
    assert {"mujoco", "numpy", "python", "seed", "format"} <= set(player.versions)
    assert [type(act).__name__ for tick, act in player.inputs if tick > 60][:2] == ["PokeReleased", "PokePressed"]


def test_chunk_with_a_wrong_checksum_is_rejected(recording):
    """A byte of the last message is changed and compressed again, so that the archive itself is valid."""
    contents = read_recording(recording)
    chunk = contents.chunk(0)
    assert chunk.compression == "zstd"
    assert chunk_messages(chunk, dict(contents.channels))
    plain = bytearray(zstandard.decompress(chunk.data))
    plain[-1] ^= 1
    spoiled = replace(chunk, data=zstandard.compress(bytes(plain)))
    assert chunk_messages(spoiled, dict(contents.channels)) is None


def test_frames_can_be_read_in_any_order(recording):
    player = RecordingPlayer(recording)
    ticks = [player.frame(number).tick for number in (199, 0, 100, 1, 198)]
    assert ticks == [250, 51, 151, 52, 249]


def test_frame_is_found_by_time(recording):
    player = RecordingPlayer(recording)
    assert [player.number_at(s) for s in (-1.0, 0.0, 0.0049, 0.005, 0.5, 99.0)] == [0, 0, 0, 1, 100, 199]


def test_poke_spans_are_within_the_recording(recording):
    spans = RecordingPlayer(recording).poke_spans()
    assert spans
    assert all(0 <= start <= end <= RecordingPlayer(recording).duration for start, end in spans)


def test_recording_can_be_opened_by_the_mcap_reader(recording):
    """The plain MCAP reader finds the channels, their schemas and the attachments."""
    with recording.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        names = {attachment.name for attachment in reader.iter_attachments()}
    topics = {channel.topic for channel in summary.channels.values()}
    assert topics >= {"/frame", "/input", "/failure", "/event", "/tactile_image", "/tf", "/contacts"}
    assert summary.statistics.message_count > 200
    assert names == {"scene.toml", "robot.zip", "map.npz", "objects.npz"}


@pytest.mark.parametrize("share", [0.0, 0.001, 0.5, 0.97, 0.999])
def test_cut_file_is_read_as_far_as_possible_or_rejected(recording, tmp_path, share):
    data = recording.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: int(share * len(data))])
    try:
        player = RecordingPlayer(cut)
    except RecordingError:
        assert share < 0.9
    else:
        assert not player.complete
        assert 0 < len(player) <= 200


@pytest.mark.parametrize("seed", range(25))
def test_file_damaged_anywhere_is_rejected_or_read_without_the_damaged_part(recording, tmp_path, seed):
    """Bytes overwritten at random: an error of ours or a shorter recording, never a crash."""
    data = bytearray(recording.read_bytes())
    chance = np.random.default_rng(seed)
    for _ in range(5):
        start = int(chance.integers(8, len(data) - 64))
        data[start : start + 40] = chance.bytes(40)
    damaged = tmp_path / "damaged.mcap"
    damaged.write_bytes(data)
    try:
        player = RecordingPlayer(damaged)
        for number in range(0, len(player), 40):
            player.frame(number)
    except RecordingError:
        return  # refused by name is as good as read around


def test_chunk_with_an_excessive_size_is_not_unpacked(recording):
    contents = read_recording(recording)
    chunk = contents.chunk(0)
    plain = bytes(MAX_CHUNK + 1)
    large = replace(
        chunk, data=zstandard.compress(plain), uncompressed_size=len(plain), uncompressed_crc=zlib.crc32(plain)
    )
    tracemalloc.start()
    try:
        assert chunk_messages(large, dict(contents.channels)) is None
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_number_of_messages_is_limited_by_the_file_size(tmp_path):
    """The smallest file that has too many: the limit is found from its size, and stated."""
    path = tmp_path / "many.mcap"
    for count, refused in ((50_000, True), (20_000, False)):
        with path.open("wb") as stream:
            writer = Writer(
                stream,
                compression=CompressionType.ZSTD,
                chunk_size=2**22,
                use_chunking=True,
                index_types=IndexType.NONE,
                enable_data_crcs=True,
            )
            channels = begin_recording(writer, {}, {})
            for number in range(count):
                writer.add_message(channels["/mark"], 0, b"", 0, number)
            writer.finish()
        contents = read_recording(path)
        if refused:
            with pytest.raises(RecordingError, match="more messages than its size allows.*The maximum.* is 2"):
                list(contents.all_messages())
        else:
            assert sum(map(len, contents.all_messages())) == count


def test_file_changed_while_open_is_named(recording, prepared, tmp_path):
    """Removed, shorter, or replaced by another recording of the same scene whose chunks are at the same places."""
    path = tmp_path / "open.mcap"
    data = recording.read_bytes()
    path.write_bytes(data)
    player = RecordingPlayer(path)
    assert player.frame(0).tick == 51
    path.write_bytes(data[: len(data) // 3])
    with pytest.raises(RecordingError, match=r"open\.mcap: the recording was changed since it was opened"):
        player.frame(150)
    place = player._contents.chunks[-2]
    other = bytearray(data)
    other[place.offset + 24 : place.offset + 28] = b"abcd"  # the checksum of another chunk
    path.write_bytes(other)
    with pytest.raises(RecordingError, match="was changed"):
        player._contents.messages(len(player._contents.chunks) - 2)
    path.unlink()
    with pytest.raises(RecordingError, match=r"open\.mcap.*cannot be read"):
        player.frame(100)


def test_file_that_is_not_a_recording_is_named(tmp_path):
    path = tmp_path / "notes.mcap"
    path.write_text("hello")
    with pytest.raises(RecordingError, match=r"notes\.mcap: this is not a recording"):
        RecordingPlayer(path)
    with pytest.raises(RecordingError, match="cannot be read"):
        RecordingPlayer(tmp_path)


def _with_member(robot, name: str, data: bytes) -> bytes:
    buffer = io.BytesIO(robot_to_zip(robot))
    with zipfile.ZipFile(buffer, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, data)
    return buffer.getvalue()


@pytest.mark.parametrize("name", ["../../etc/cron.d/x", "/etc/passwd", "assets/../../x", "a\\..\\b"])
def test_robot_archive_with_outside_paths_is_rejected(prepared, name):
    with pytest.raises(RecordingError, match="outside itself"):
        robot_from_zip(_with_member(prepared.robot, name, b"x"), file="x.mcap")


def test_compression_bomb_is_rejected_before_unpacking(prepared, monkeypatch):
    monkeypatch.setattr("tactile_maps.session.bundle._MAX_UNPACKED", 50_000_000)
    with pytest.raises(RecordingError, match="implausible size"):
        robot_from_zip(_with_member(prepared.robot, "assets/zeros", bytes(60_000_000)), file="x.mcap")


def test_pickled_mesh_is_rejected(prepared):
    buffer = io.BytesIO()
    np.save(buffer, np.array([{"code": 1}], dtype=object), allow_pickle=True)
    members = zipfile.ZipFile(io.BytesIO(robot_to_zip(prepared.robot)))
    rebuilt = io.BytesIO()
    with zipfile.ZipFile(rebuilt, "w") as archive:
        for name in members.namelist():
            archive.writestr(name, buffer.getvalue() if name == "meshes/0.npy" else members.read(name))
    with pytest.raises(RecordingError, match=r"meshes/0\.npy: only arrays of numbers"):
        robot_from_zip(rebuilt.getvalue(), file="x.mcap")


def npy_header(text: str) -> bytes:
    """An npy file that has only a header."""
    padded = text.ljust(118) + "\n"
    return b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded.encode()


HEADER = json.loads(zipfile.ZipFile(io.BytesIO(robot_to_zip(bar()))).read("header.json"))


@pytest.mark.parametrize(
    ("name", "data", "place"),
    [
        (
            "meshes/0.npy",
            npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (10000000000000, 3), }"),
            "0.npy",
        ),
        ("meshes/0.npy", npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 3), }"), "0.npy"),
        ("meshes/0.npy", npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': " + "(" * 5000 + "}"), "0.npy"),
        ("meshes/0.npy", npy_header("{'descr': '<f8', 'fortran_order': False, 'shape': " + "-" * 9000 + "1}"), "0.npy"),
        ("meshes/0.npy", b"", "0.npy"),
        ("meshes/0.npy", pack_array(np.full((3, 3), np.nan)), "link 0"),
        ("meshes/0.npy", pack_array(np.zeros((3, 3), dtype=complex)), "0.npy"),
        ("meshes/0.npy", pack_array(np.zeros(9)), "link 0"),
        ("meshes/0.faces.npy", pack_array(np.array([[0.0, np.nan, 1.0]])), "link 0"),
        ("meshes/0.faces.npy", pack_array(np.array([[0, 1, 10**9]])), "link 0"),
        ("header.json", b"[" * 200_000, "header.json"),
        ("header.json", json.dumps(HEADER | {"home": []}).encode(), "home"),
        ("header.json", json.dumps(HEADER | {"home": ["nan"]}).encode(), "home[0]"),
        ("header.json", json.dumps(HEADER | {"links": [3]}).encode(), "links[0]"),
        (
            "header.json",
            json.dumps(HEADER | {"joints": [HEADER["joints"][0] | {"slide": 1}]}).encode(),
            "joints[0].slide",
        ),
    ],
)
def test_damaged_robot_part_is_rejected_with_its_place(name, data, place):
    members = zipfile.ZipFile(io.BytesIO(robot_to_zip(bar())))
    assert name in members.namelist()
    rebuilt = io.BytesIO()
    with zipfile.ZipFile(rebuilt, "w") as archive:
        for known in members.namelist():
            archive.writestr(known, data if known == name else members.read(known))
    with pytest.raises(RecordingError) as refused:
        robot_from_zip(rebuilt.getvalue(), file="x.mcap")
    assert refused.value.file == "x.mcap"
    assert place in refused.value.place


def test_missing_mesh_is_still_marked_as_missing(tmp_path):
    file = tmp_path / "lost.xml"
    file.write_text(
        '<mujoco><asset><mesh name="ball" file="ball.stl"/></asset><worldbody><body name="tip"><joint/>'
        '<geom type="mesh" mesh="ball"/></body></worldbody></mujoco>'
    )
    again = robot_from_zip(robot_to_zip(load_mjcf(file)), file="x.mcap")
    assert again.link("tip").missing == ("ball",)


def test_robot_without_limits_is_restored():
    free = replace(bar(), joints=(Joint("hinge", float("-inf"), float("inf")),), findings=(Finding("a", "b", "c", 2),))
    again = robot_from_zip(robot_to_zip(free), file="x.mcap")
    assert (again.joints, again.findings, again.home.tolist()) == (free.joints, free.findings, free.home.tolist())


def test_recording_of_another_format_is_named(tmp_path, monkeypatch, prepared):
    monkeypatch.setattr("tactile_maps.recording.file.mcap_file.FORMAT", "5")
    old = tmp_path / "old.mcap"
    with Recorder(prepared, old) as recorder:
        recorder.write(Session(prepared).frame, ())
    monkeypatch.undo()
    for opened in (RecordingPlayer, lambda path: recover(path, tmp_path / "new.mcap")):
        with pytest.raises(RecordingError, match=r"old\.mcap: the recording has another format \(found: 5\)"):
            opened(old)


def test_objects_are_restored_from_bytes():
    (again,) = objects_from_bytes(objects_to_bytes([BALL_BODY]), [BALL])
    assert again.spec == BALL
    assert again.mesh.vertices.tobytes() == BALL_BODY.mesh.vertices.tobytes()
    assert again.mesh.faces.tobytes() == BALL_BODY.mesh.faces.tobytes()
    assert objects_from_bytes(objects_to_bytes([]), []) == ()


@pytest.mark.parametrize(
    ("data", "specs"),
    [
        (b"", []),
        (b"PK", [BALL]),
        (objects_to_bytes([BALL_BODY]), []),
        (objects_to_bytes([BALL_BODY]), [ObjectSpec("box", "box", size=(1, 1, 1))]),
        (pack_arrays({"names": ["ball"]}, {}), [BALL]),
        (pack_arrays({"names": ["ball"]}, {"vertices 0": np.zeros(4), "faces 0": np.zeros((0, 3))}), [BALL]),
    ],
)
def test_damaged_objects_and_those_of_another_scene_are_rejected(data, specs):
    with pytest.raises(RecordingError):
        objects_from_bytes(data, specs)


def test_active_effects_are_known_at_every_tick(recording):
    player = RecordingPlayer(recording)
    ((tick, act),) = [(tick, act) for tick, act in player.inputs if isinstance(act, EffectsChanged)]
    assert player.runtime_settings_at(tick - 1).effects == player.prepared.scene.effects
    assert player.runtime_settings_at(tick).effects == player.runtime_settings_at(10**6).effects == act.effects
    assert player.failure is None


def test_names_of_taxels_are_recorded(prepared, tmp_path):
    """Ids, modules and channels, at both ends of their range and repeated, come back with the skin."""
    patches = tuple(
        replace(patch, taxels=replace(patch.taxels, identity=TaxelIdentity(ids, ids // 12, ids % 12)))
        for patch in prepared.skin.patches
        for ids in [np.array([2**31 - 1, 0, 87012] * len(patch.taxels))[: len(patch.taxels)]]
    )
    skin = replace(prepared.skin, patches=patches)
    named = replace(prepared, skin=skin, map=replace(prepared.map, skin=skin))
    record(named, tmp_path / "named.mcap", ticks=2)
    read = RecordingPlayer(tmp_path / "named.mcap").prepared
    for found in (read.skin.identity, read.map.skin.identity):
        for field in ("ids", "modules", "channels"):
            np.testing.assert_array_equal(getattr(found, field), getattr(skin.identity, field))
