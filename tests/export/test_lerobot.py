"""The data set is laid out as LeRobot 3.0 says; pressures are ours to single precision."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tactile_maps.core.errors import ExportError
from tactile_maps.export.export import ExportOptions, export_recording
from tactile_maps.recording.encoding.annotations import Annotations, LabelledEpisode, Outcome, save_annotations

parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed (extra export)")
av = pytest.importorskip("av", reason="PyAV is not installed (extra export)")

OF_TORCHVISION = pytest.mark.filterwarnings("ignore:The video decoding and encoding capabilities of torchvision")


@pytest.fixture(scope="module")
def folder(player, tmp_path_factory):
    target = tmp_path_factory.mktemp("lerobot") / "set"
    export_recording(player, target, to="lerobot")
    return target


def test_rows_contain_the_frames_in_single_precision(folder, frames):
    rows = parquet.read_table(folder / "data/chunk-000/file-000.parquet").to_pydict()
    for key, part in (
        ("observation.tactile", lambda frame: frame.pressures),
        ("observation.state", lambda frame: frame.posture),
        ("action", lambda frame: frame.command.posture),
    ):
        expected = np.array([part(frame) for frame in frames], dtype=np.float32)
        np.testing.assert_array_equal(np.array(rows[key], dtype=np.float32), expected)
    assert rows["index"] == rows["frame_index"] == list(range(len(frames)))
    np.testing.assert_allclose(rows["timestamp"], np.arange(len(frames)) / 200, atol=1e-6)


@OF_TORCHVISION
def test_loader_of_lerobot_reads_the_same_data(folder, frames):
    """LeRobotDataset itself, which brings torch (4 GB): a job of its own, see the guide's data page."""
    datasets = pytest.importorskip("lerobot.datasets.lerobot_dataset", reason="lerobot is not installed (4 GB)")
    data = datasets.LeRobotDataset("local/touch", root=folder, video_backend="pyav")
    assert len(data) == len(frames)
    items = [data[row] for row in range(0, len(frames), 7)]
    read = np.stack([item["observation.tactile"].numpy() for item in items])
    np.testing.assert_array_equal(read, np.array([frame.pressures for frame in frames[::7]], dtype=np.float32))
    assert items[0]["observation.images.tactile"].shape[0] == 3


@OF_TORCHVISION
def test_loader_of_lerobot_reads_windows_and_positions_of_taxels(player, frames, tmp_path):
    """Needs LeRobot, see above."""
    datasets = pytest.importorskip("lerobot.datasets.lerobot_dataset", reason="lerobot is not installed (4 GB)")
    target = tmp_path / "windows"
    export_recording(player, target, to="lerobot", options=ExportOptions(fps=20))
    data = datasets.LeRobotDataset("local/touch", root=target, video_backend="pyav")
    items = [data[row] for row in range(len(data))]
    masks = [item["observation.tactile_window_mask"].numpy().astype(bool) for item in items]
    windows = [item["observation.tactile_window"].numpy()[mask] for item, mask in zip(items, masks, strict=True)]
    read = np.concatenate(windows)
    np.testing.assert_array_equal(read, np.array([frame.pressures for frame in frames[: len(read)]], dtype=np.float32))
    assert len(read) > 0.9 * len(frames)
    points = np.array(data.features["observation.tactile"]["info"]["points"])
    assert points.shape == (len(frames[0].pressures), 6)


def test_features_describe_the_columns(folder, player):
    info = json.loads((folder / "meta/info.json").read_text())
    schema = parquet.read_schema(folder / "data/chunk-000/file-000.parquet")
    assert info["codebase_version"] == "v3.0"
    assert info["fps"] == 200
    for key, feature in info["features"].items():
        if feature["dtype"] == "video":
            assert key not in schema.names
            continue
        kind = schema.field(key).type
        if feature["shape"] == [1]:
            assert str(kind).replace("float", "float32") == feature["dtype"]
        else:
            assert kind.list_size == feature["shape"][0] == len(feature["names"])
    assert info["features"]["observation.tactile"]["names"][1] == "id_1003"
    path = info["video_path"].format(video_key="observation.images.tactile", chunk_index=0, file_index=0)
    with av.open(str(folder / path)) as film:
        stream = film.streams.video[0]
        times = [float(frame.pts * stream.time_base) for frame in film.decode(video=0)]
        assert [stream.height, stream.width, 3] == info["features"]["observation.images.tactile"]["shape"]
    np.testing.assert_allclose(times, np.arange(len(player)) / 200, atol=1e-4)


def test_statistics_cover_all_frames(folder, frames):
    stats = json.loads((folder / "meta/stats.json").read_text())["observation.tactile"]
    pressures = np.array([frame.pressures for frame in frames], dtype=np.float32).astype(float)
    for name, values in (
        ("min", pressures.min(0)),
        ("max", pressures.max(0)),
        ("mean", pressures.mean(0)),
        ("std", pressures.std(0)),
    ):
        np.testing.assert_allclose(stats[name], values, rtol=1e-6, atol=1e-6)
    assert stats["count"] == [len(frames)]


@pytest.mark.long
def test_gap_starts_another_episode(damaged, tmp_path):
    player = export_recording(damaged, tmp_path / "set", to="lerobot")
    (first, second) = parquet.read_table(tmp_path / "set/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert first["dataset_to_index"] == second["dataset_from_index"] == first["length"]
    assert first["length"] + second["length"] == second["dataset_to_index"] == len(player)
    rows = parquet.read_table(tmp_path / "set/data/chunk-000/file-000.parquet").to_pydict()
    start = rows["episode_index"].index(1)
    assert start == first["length"]
    assert rows["frame_index"][start] == 0
    assert rows["timestamp"][start] == 0.0
    info = json.loads((tmp_path / "set/meta/info.json").read_text())
    assert info["total_episodes"] == 2
    assert "frames missing" in info["tactile_maps"]["damage"]


def test_tasks_are_indexed_by_their_text(folder, player):
    table = parquet.read_table(folder / "meta/tasks.parquet")
    index = json.loads(table.schema.metadata[b"pandas"])
    assert (index["index_columns"], index["column_indexes"]) == (["task"], [])
    assert table.to_pydict() == {"task_index": [0], "task": [player.prepared.scene.name]}


def test_labelled_episodes_are_exported_with_their_instructions_as_tasks(path, tmp_path):
    copy = tmp_path / "labelled.mcap"
    copy.write_bytes(path.read_bytes())
    said = (
        LabelledEpisode(10, 39, "press", "press the arm gently", Outcome.SUCCESS),
        LabelledEpisode(60, 69, "lift"),
        LabelledEpisode(80, 89, "again", "press the arm gently"),
    )
    save_annotations(copy, Annotations(episodes=said))
    player = export_recording(copy, tmp_path / "set", to="lerobot")
    rows = parquet.read_table(tmp_path / "set/data/chunk-000/file-000.parquet").to_pydict()
    assert rows["episode_index"] == [0] * 30 + [1] * 10 + [2] * 10
    assert rows["task_index"] == [0] * 30 + [1] * 10 + [0] * 10
    assert rows["frame_index"] == [*range(30), *range(10), *range(10)]
    first = player.frame(player.number_at(10 * 0.005 - player.times[0]))
    np.testing.assert_array_equal(np.float32(rows["observation.tactile"][0]), first.pressures.astype(np.float32))
    tasks = parquet.read_table(tmp_path / "set/meta/tasks.parquet").to_pydict()
    assert tasks == {"task_index": [0, 1], "task": ["press the arm gently", "lift"]}
    episodes = parquet.read_table(tmp_path / "set/meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [one["tasks"] for one in episodes] == [["press the arm gently"], ["lift"], ["press the arm gently"]]
    info = json.loads((tmp_path / "set/meta/info.json").read_text())
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (3, 50, 2)
    assert [one["length"] for one in episodes] == [30, 10, 10]
    assert [(one["dataset_from_index"], one["dataset_to_index"]) for one in episodes] == [(0, 30), (30, 40), (40, 50)]
    film = "videos/observation.images.tactile"
    spans = [(one[f"{film}/from_timestamp"], one[f"{film}/to_timestamp"]) for one in episodes]
    np.testing.assert_allclose(spans, [(0.0, 0.15), (0.15, 0.2), (0.2, 0.25)])
    assert [one["stats/observation.tactile/count"] for one in episodes] == [[30], [10], [10]]
    stats = json.loads((tmp_path / "set/meta/stats.json").read_text())
    pressures = np.array(rows["observation.tactile"])
    for name in ("observation.tactile", "observation.state", "action", "timestamp"):
        assert stats[name]["count"] == [50]
    np.testing.assert_allclose(stats["observation.tactile"]["mean"], pressures.mean(0), rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(stats["observation.tactile"]["std"], pressures.std(0), rtol=1e-4, atol=1e-4)
    assert stats["observation.images.tactile"]["count"][0] == sum(
        one["stats/observation.images.tactile/count"][0] for one in episodes
    )
    with av.open(str(tmp_path / "set" / film / "chunk-000/file-000.mp4")) as video:
        assert sum(1 for _ in video.decode(video=0)) == 50
    last = player.frame(player.number_at(89 * 0.005 - player.times[0]))
    np.testing.assert_array_equal(np.float32(rows["observation.tactile"][-1]), last.pressures.astype(np.float32))


def test_places_of_taxels_are_points_of_position_and_normal_in_the_frames_of_their_links(folder, player):
    info = json.loads((folder / "meta/info.json").read_text())["features"]["observation.tactile"]["info"]
    skin = player.prepared.skin
    points = np.array(info["points"])
    assert points.shape == (len(skin), 6)
    first = skin.patches[0].taxels
    np.testing.assert_allclose(points[: len(first), :3], first.positions, atol=1e-6)
    np.testing.assert_allclose(points[: len(first), 3:], first.normals, atol=1e-6)
    assert (info["links"][0], info["frame"], info["length_unit"]) == (skin.patches[0].link, "link", "m")


def test_lower_rate_keeps_all_readings_since_the_previous_row_as_a_window(player, frames, tmp_path):
    """The first row has one reading and all others four, at 200 ticks and 50 rows per second."""
    export_recording(player, tmp_path / "set", to="lerobot", options=ExportOptions(fps=50))
    info = json.loads((tmp_path / "set/meta/info.json").read_text())
    table = parquet.read_table(tmp_path / "set/data/chunk-000/file-000.parquet")
    rows = table.to_pydict()
    count = len(frames[0].pressures)
    assert info["fps"] == 50
    assert info["features"]["observation.tactile_window"]["shape"] == [4, count]
    windows = np.array(rows["observation.tactile_window"], dtype=np.float32)
    masks = np.array(rows["observation.tactile_window_mask"])
    assert windows.shape == (len(rows["index"]), 4, count)
    assert masks[0].tolist() == [False, False, False, True]
    assert masks[1:].all()
    readings = np.array([frame.pressures for frame in frames], dtype=np.float32)
    np.testing.assert_array_equal(windows[0], np.tile(readings[0], (4, 1)))
    np.testing.assert_array_equal(windows[1:].reshape(-1, count), readings[1 : 4 * len(windows) - 3])
    np.testing.assert_array_equal(windows[:, -1], np.array(rows["observation.tactile"], dtype=np.float32))
    np.testing.assert_allclose(rows["observation.tactile_window_time"][2], [-0.015, -0.01, -0.005, 0], atol=1e-6)
    stats = json.loads((tmp_path / "set/meta/stats.json").read_text())
    assert np.shape(stats["observation.tactile_window"]["max"]) == (4, count)
    np.testing.assert_allclose(stats["observation.tactile_window"]["max"], windows.max(axis=0), rtol=1e-6)


def test_rate_above_that_of_the_readings_is_rejected(player, tmp_path):
    with pytest.raises(ExportError, match=r"invalid number of rows a second \(found: 300\)\. Choose 1 to 200"):
        export_recording(player, tmp_path / "set", to="lerobot", options=ExportOptions(fps=300))
