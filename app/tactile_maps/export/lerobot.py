"""A recording as a LeRobot data set, version 3.0 (https://huggingface.co/docs/lerobot/lerobot-dataset-v3).

Episodes are those labelled by the user; their task is the instruction or else the label. Without labelled episodes,
each run of ticks without a gap is an episode, and its task is the scene's name. Frames outside of episodes are left
out. Features: joint positions and velocities (``observation.state``, ``observation.velocity``), pressures by taxel
(``observation.tactile`` [Pa], named by hardware id), the commanded positions (``action``), and a film of the tactile
image (``observation.images.tactile``) at the rate of ticks. All are in single precision, as LeRobot requires. Readings
of a real skin come at any time: their rows are at equal steps, at the rate at which they were usually sent, each with
the newest reading; in counts if it was not calibrated, as stated in ``meta/info.json`` (``tactile_unit``). Without
joints there are no features of joints.

At a lower rate of rows than that of the readings (``fps``), each row also has all readings since the previous row:
``observation.tactile_window`` (w, n), oldest first and the newest last, ``observation.tactile_window_mask`` (w,), and
``observation.tactile_window_time`` (w,) relative to the row [s]. Shorter windows are padded at the front with their
oldest reading, where the mask is False. LeRobot has no format for sensors of several rates; the name is that of its
discussion 2421. The places of the taxels are in ``meta/info.json``, as ``info`` of the feature.

A skin with shear has ``observation.tactile3`` (n, 3): pressure and shear along t1 and t2 of each taxel; NaN for shear
in frames without; and with windows ``observation.tactile3_window`` (w, n, 3).
"""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import ExportError, packages_of
from tactile_maps.core.progress import Progress, part_of_progress
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.export.film import open_film
from tactile_maps.export.sinks import RowGroups
from tactile_maps.export.tables import (
    BATCH,
    LOOKING,
    Episode,
    episodes,
    has_shear,
    highest_reading,
    shear_rows,
    taxel_labels,
    units_of,
)
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.maps.pressure_colours import colour_image, rounded_scale
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin

_VIDEO = "observation.images.tactile"
_FILE = "chunk-000/file-000"
_WIDTH = 128
_INDEX = ("timestamp", "frame_index", "episode_index", "index", "task_index")
_WINDOW = "observation.tactile_window"
_MASK = f"{_WINDOW}_mask"
_TIME = f"{_WINDOW}_time"
_THREE = "observation.tactile3"
"""Pressure and shear of each taxel."""
_THREE_WINDOW = f"{_THREE}_window"
_KEYS = {
    "observation.state": lambda frame: frame.posture,
    "observation.velocity": lambda frame: frame.velocity,
    "observation.tactile": lambda frame: frame.pressures,
    "action": lambda frame: frame.command.posture,
}


def write_lerobot(player: RecordingPlayer, folder: Path, *, fps: int | None = None, progress: Progress) -> None:
    """Write the data set to a new folder.

    Args:
        player: The recording.
        folder: The folder; it must not exist.
        fps: Rows per second, each with a window of all readings since the previous one; None for every reading.
        progress: Receives a description and the progress, 0 to 1; may raise to cancel.

    Raises:
        ExportError: A package is not installed, the number of ticks per second is not a whole number, or ``fps`` is
            above the rate of the readings.
    """
    with packages_of("export"):
        import pyarrow.parquet as parquet
    rows_of = _rows_of(player)
    if fps is not None:
        if not 1 <= fps <= rows_of.rate:
            remedy = f"Choose 1 to {rows_of.rate}, the rate of the readings"
            raise ExportError("invalid number of rows a second", value=fps, remedy=remedy)
        rows_of = _at_rate(player, fps)
    found = rows_of.episodes
    counts = _in_counts(player)
    sheared = has_shear(player)
    statistics = [_Statistics() for _ in found]
    image = TactileImage(player.prepared.map, width=_WIDTH)
    rows, columns = image.shape
    size = (rows + rows % 2, columns + columns % 2)
    scale = rounded_scale(1e-3 * highest_reading(player, part_of_progress(progress, 0.0, LOOKING)))
    progress = part_of_progress(progress, LOOKING, 1.0)
    rate = rows_of.rate
    _folder_of(folder / "data" / f"{_FILE}.parquet")
    video = folder / "videos" / _VIDEO / f"{_FILE}.mp4"
    _folder_of(video)
    with ExitStack() as files:
        film = files.enter_context(open_film(video, size[::-1], Fraction(rate), quality=18))
        writer = None
        done = 0
        batch = max(BATCH // rows_of.window, 1)
        for start in range(0, len(rows_of.frames), batch):
            progress("Exporting", start / len(rows_of.frames))
            frames = [player.frame(int(number)) for number in rows_of.frames[start : start + batch]]
            windows = _windows(player, rows_of, slice(start, start + batch), counts=counts, sheared=sheared)
            if sheared:
                windows[_THREE] = _three(frames, counts=counts)
            table = _rows(frames, done, found, rate, statistics, windows, counts=counts)
            if writer is None:
                path = folder / "data" / f"{_FILE}.parquet"
                writer = RowGroups(parquet.ParquetWriter(path, table.schema, compression="snappy"), files)
            writer.add(table)
            for number, frame in enumerate(frames, start=done):
                picture = np.full((*size, 3), 255, dtype=np.uint8)
                picture[:rows, :columns] = colour_image(image, frame.pressures, scale)
                film.add(picture)
                statistics[_episode_of(number, found)].add(_VIDEO, picture.reshape(-1, 3) / 255.0)
            done += len(frames)
    progress("Exporting", 1.0)
    _write_meta(player, folder, rows_of, statistics, size, counts=counts, sheared=sheared)


@dataclass(frozen=True)
class _RowsOf:
    """Rows of the data set, ``rate`` per second within each episode.

    Attributes:
        rate: Rows per second.
        frames: (rows,) number of the frame of each row.
        episodes: Episodes, with rows instead of frames.
        since: (rows,) number of the first frame since the previous row; None for rows without windows.
    """

    rate: int
    frames: IntArray
    episodes: list[Episode]
    since: IntArray | None = None

    @property
    def window(self) -> int:
        """Largest number of readings of a row."""
        return 1 if self.since is None else int((self.frames - self.since).max()) + 1


def _rows_of(player: RecordingPlayer) -> _RowsOf:
    """Return a row for each tick; for a real skin, whose readings come at any time, the newest at equal steps."""
    if player.measured is None:
        rate = 1.0 / player.prepared.scene.tick
        if abs(rate - round(rate)) > 1e-6 * rate:
            remedy = "Record with a tick of 0.005 s, 0.004 s, ... or export to parquet"
            raise ExportError("LeRobot needs a whole number of ticks a second", value=f"{rate:.6g}", remedy=remedy)
        return _each_tick(round(rate), episodes(player))
    steps = np.diff(player.times)
    usual = max(round(1 / float(np.median(steps))), 1) if len(steps) else 1
    return replace(_at_rate(player, usual), since=None)


def _at_rate(player: RecordingPlayer, rate: int) -> _RowsOf:
    """Return rows at a rate of the readings or a lower one, with the first frame since the previous row."""
    frames = []
    since = []
    sampled = []
    done = 0
    for one in episodes(player):
        times = player.times[one.first : one.first + one.frames]
        count = int((times[-1] - times[0]) * rate + 1e-6) + 1
        rows = np.searchsorted(times, times[0] + np.arange(count) / rate + 1e-9, side="right") - 1
        sampled.append(replace(one, first=done, frames=count))
        frames.append(one.first + rows)
        since.append(one.first + np.minimum(np.concatenate([[0], rows[:-1] + 1]), rows))
        done += count
    return _RowsOf(rate, np.concatenate(frames), sampled, np.concatenate(since))


def _windows(
    player: RecordingPlayer, rows_of: _RowsOf, part: slice, *, counts: bool, sheared: bool
) -> dict[str, NDArray[Any]]:
    """Return the columns of the windows of some rows; none without windows."""
    if rows_of.since is None:
        return {}
    size = rows_of.window
    values = []
    masks = []
    times = []
    for newest, first in zip(rows_of.frames[part].tolist(), rows_of.since[part].tolist(), strict=True):
        own = np.arange(newest - size + 1, newest + 1)
        masks.append(own >= first)
        own = np.maximum(own, first)
        frames = [player.frame(number) for number in range(first, newest + 1)]
        readings = _three(frames, counts=counts) if sheared else _pressures(frames, counts=counts)
        values.append(readings[own - first])
        times.append(player.times[own] - player.times[newest])
    windows = np.stack(values)
    columns = {_WINDOW: windows[..., 0], _THREE_WINDOW: windows} if sheared else {_WINDOW: windows}
    return columns | {_MASK: np.stack(masks), _TIME: np.stack(times).astype(np.float32)}


def _pressures(frames: list[Frame], *, counts: bool) -> NDArray[np.float32]:
    """Return the pressures (frames, taxels) [Pa], or counts."""
    unit = np.float32(1e-3 if counts else 1.0)  # one count is stored as 1 kPa
    return np.asarray(unit * np.stack([frame.pressures for frame in frames]).astype(np.float32))


def _three(frames: list[Frame], *, counts: bool) -> NDArray[np.float32]:
    """Return pressure and shear (frames, taxels, 3) [Pa], or counts."""
    unit = np.float32(1e-3 if counts else 1.0)
    shear = unit * shear_rows(frames).astype(np.float32)
    return np.concatenate([_pressures(frames, counts=counts)[:, :, None], shear], axis=2)


def _each_tick(rate: int, found: list[Episode]) -> _RowsOf:
    """Return a row for every frame of every episode."""
    firsts = np.cumsum([0, *(one.frames for one in found)]).tolist()
    rows = [replace(one, first=first) for one, first in zip(found, firsts[:-1], strict=True)]
    return _RowsOf(rate, np.concatenate([np.arange(one.first, one.first + one.frames) for one in found]), rows)


def _in_counts(player: RecordingPlayer) -> bool:
    """Whether the readings are counts instead of pressures.

    Raises:
        ExportError: The recording has both; a data set has one unit.
    """
    found = {units is ReadingUnits.COUNTS for units in units_of(player)}
    if len(found) > 1:
        remedy = "Record it again in one mode: tactile-maps listen RECORDING --mode kPa -o OTHER.mcap"
        raise ExportError("some readings are counts and others pressures", file=player.path, remedy=remedy)
    return found == {True}


def _folder_of(path: Path) -> None:
    path.parent.mkdir(parents=True)


def _tasks(found: list[Episode]) -> list[str]:
    """Return the tasks of the episodes without repetitions."""
    return list(dict.fromkeys(one.task for one in found))


def _episode_of(number: int, found: list[Episode]) -> int:
    return bisect_right(found, number, key=lambda one: one.first) - 1


def _rows(
    frames: list[Frame],
    first: int,
    found: list[Episode],
    rate: int,
    statistics: list[_Statistics],
    windows: Mapping[str, NDArray[Any]],
    *,
    counts: bool,
) -> Any:
    import pyarrow as arrow

    index = np.arange(first, first + len(frames))
    firsts = np.array([one.first for one in found])
    tasks = _tasks(found)
    episode = np.searchsorted(firsts, index, side="right") - 1
    within = index - firsts[episode]
    columns: dict[str, Any] = {}
    parts = {key: part for key, part in _KEYS.items() if part(frames[0]).size}
    values = {key: np.stack([part(frame) for frame in frames]).astype(np.float32) for key, part in parts.items()}
    if counts:
        values["observation.tactile"] *= np.float32(1e-3)  # one count is stored as 1 kPa
    plain = {
        "timestamp": (within / rate).astype(np.float32),
        "frame_index": within,
        "episode_index": episode,
        "index": index,
        "task_index": np.array([tasks.index(found[number].task) for number in episode.tolist()]),
    }
    for key, rows in values.items():
        columns[key] = arrow.FixedSizeListArray.from_arrays(arrow.array(rows.ravel()), rows.shape[1])
    for key, rows in windows.items():
        columns[key] = arrow.array(rows.tolist(), type=_arrow_type(rows))
        values[key] = rows.reshape(len(rows), -1)
    columns |= {key: arrow.array(rows) for key, rows in plain.items()}
    for number in np.unique(episode).tolist():
        for key, rows in (values | {key: rows[:, None] for key, rows in plain.items()}).items():
            statistics[number].add(key, rows[episode == number])
    return arrow.table(columns)


def _arrow_type(rows: NDArray[Any]) -> Any:
    """Return the type of a column of lists, or of lists of lists."""
    import pyarrow as arrow

    kind = arrow.bool_() if rows.dtype == bool else arrow.float32()
    for _ in range(rows.ndim - 1):
        kind = arrow.list_(kind)
    return kind


class _Statistics:
    """Running minimum, maximum, mean and standard deviation of each number, and quantiles of a sample."""

    _MOST = 2000

    def __init__(self) -> None:
        self._sums: dict[str, list[NDArray[np.float64]]] = {}
        self._counts: dict[str, int] = {}
        self._samples: dict[str, list[NDArray[np.float64]]] = {}

    def add(self, key: str, rows: NDArray[Any]) -> None:
        """Add rows (k, n)."""
        rows = rows.astype(np.float64)
        self._combine(key, [rows.min(axis=0), rows.max(axis=0), rows.sum(axis=0), (rows**2).sum(axis=0)], len(rows))
        kept = self._samples.setdefault(key, [])
        if len(kept) < self._MOST:
            kept.append(rows[len(rows) // 2].copy())  # a view would keep all rows in memory

    def merge(self, other: _Statistics) -> None:
        """Add the rows of another."""
        for key, sums in other._sums.items():
            self._combine(key, sums, other._counts[key])
            self._samples[key] = self._samples.get(key, []) + other._samples[key]

    def _combine(self, key: str, sums: list[NDArray[np.float64]], count: int) -> None:
        """Add minimum, maximum, sum and sum of squares of ``count`` rows."""
        if key in self._sums:
            operations = (np.minimum, np.maximum, np.add, np.add)
            pairs = zip(operations, self._sums[key], sums, strict=True)
            sums = [operation(own, new) for operation, own, new in pairs]
        self._sums[key] = sums
        self._counts[key] = self._counts.get(key, 0) + count

    def result(self, window: int) -> dict[str, dict[str, list[Any]]]:
        """Return the statistics by feature; those of the film by colour, as LeRobot requires, and those of a window of
        ``window`` readings in its shape.
        """
        return {key: self._of(key, window) for key in self._sums}

    def _of(self, key: str, window: int) -> dict[str, list[Any]]:
        low, high, total, squares = self._sums[key]
        count = self._counts[key]
        mean = total / count
        found = {"min": low, "max": high, "mean": mean, "std": np.sqrt(np.maximum(squares / count - mean**2, 0.0))}
        shares = {"q01": 0.01, "q10": 0.1, "q50": 0.5, "q90": 0.9, "q99": 0.99}
        sample = np.stack(self._samples[key])
        found |= {name: np.quantile(sample, share, axis=0) for name, share in shares.items()}
        shapes = {_VIDEO: (3, 1, 1), _WINDOW: (window, -1), _THREE: (-1, 3), _THREE_WINDOW: (window, -1, 3)}
        shape = shapes.get(key, low.shape)
        return {name: values.reshape(shape).tolist() for name, values in found.items()} | {"count": [count]}


def _write_meta(
    player: RecordingPlayer,
    folder: Path,
    rows_of: _RowsOf,
    statistics: list[_Statistics],
    size: tuple[int, ...],
    *,
    counts: bool,
    sheared: bool,
) -> None:
    import pyarrow as arrow
    import pyarrow.parquet as parquet

    meta = folder / "meta"
    (meta / "episodes" / "chunk-000").mkdir(parents=True)
    whole = _Statistics()
    for one in statistics:
        whole.merge(one)
    (meta / "info.json").write_text(
        json.dumps(_info(player, rows_of, size, counts=counts, sheared=sheared), indent=4), encoding="utf8"
    )
    (meta / "stats.json").write_text(json.dumps(whole.result(rows_of.window), indent=4), encoding="utf8")
    names = _tasks(rows_of.episodes)
    tasks = arrow.table({"task_index": arrow.array(range(len(names))), "task": arrow.array(names)})
    parquet.write_table(tasks.replace_schema_metadata(_PANDAS_INDEX), meta / "tasks.parquet")
    with ExitStack() as files:
        writer = None
        for number, (episode, own) in enumerate(zip(rows_of.episodes, statistics, strict=True)):
            row = arrow.Table.from_pylist([_episode_row(number, episode, own.result(rows_of.window), rows_of.rate)])
            if writer is None:
                writer = RowGroups(parquet.ParquetWriter(meta / "episodes" / f"{_FILE}.parquet", row.schema), files)
            writer.add(row)


_PANDAS_INDEX = {
    "pandas": json.dumps(
        {
            "index_columns": ["task"],
            "column_indexes": [],
            "columns": [
                {
                    "name": "task_index",
                    "field_name": "task_index",
                    "pandas_type": "int64",
                    "numpy_type": "int64",
                    "metadata": None,
                },
                {
                    "name": "task",
                    "field_name": "task",
                    "pandas_type": "unicode",
                    "numpy_type": "object",
                    "metadata": None,
                },
            ],
            "creator": {"library": "pyarrow"},
            "pandas_version": "2.0.0",
        }
    )
}
"""Metadata by which pandas, and so LeRobot, uses the tasks as the table's index."""


def _episode_row(number: int, one: Episode, stats: Mapping[str, Mapping[str, Any]], rate: int) -> dict[str, Any]:
    row: dict[str, Any] = {
        "episode_index": number,
        "tasks": [one.task],
        "length": one.frames,
        "data/chunk_index": 0,
        "data/file_index": 0,
        f"videos/{_VIDEO}/chunk_index": 0,
        f"videos/{_VIDEO}/file_index": 0,
        f"videos/{_VIDEO}/from_timestamp": one.first / rate,
        f"videos/{_VIDEO}/to_timestamp": (one.first + one.frames) / rate,
        "dataset_from_index": one.first,
        "dataset_to_index": one.first + one.frames,
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
    }
    return row | {f"stats/{key}/{name}": value for key, of in stats.items() for name, value in of.items()}


def _places(skin: Skin) -> dict[str, Any]:
    """Return the places of the taxels: 6-D points of position [m] and outward normal, in the frame of their link."""
    parts = [patch.taxels for patch in skin.patches]
    points = np.concatenate([np.hstack([part.positions, part.normals]) for part in parts])
    return {
        "point_names": ["x", "y", "z", "nx", "ny", "nz"],
        "points": np.round(points, 6).tolist(),
        "links": [patch.link for patch in skin.patches for _ in range(len(patch.taxels))],
        "frame": "link",
        "length_unit": "m",
    }


def _info(
    player: RecordingPlayer, rows_of: _RowsOf, size: tuple[int, ...], *, counts: bool, sheared: bool
) -> dict[str, Any]:
    """Return the content of ``meta/info.json``."""
    prepared = player.prepared
    found = rows_of.episodes
    features = _value_features(prepared)
    if sheared:
        features |= _shear_features(prepared)
    if rows_of.since is not None:
        features |= _window_features(rows_of.window, len(prepared.skin), sheared=sheared)
    features[_VIDEO] = _video_feature(size, rows_of.rate)
    for key in _INDEX:
        features[key] = {"dtype": "float32" if key == "timestamp" else "int64", "shape": [1], "names": None}
    return {
        "codebase_version": "v3.0",
        "robot_type": prepared.robot.name,
        "total_episodes": len(found),
        "total_frames": len(rows_of.frames),
        "total_tasks": len(_tasks(found)),
        "chunks_size": 1000,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 200,
        "fps": rows_of.rate,
        "splits": {"train": f"0:{len(found)}"},
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
        "features": features,
        "tactile_maps": {
            "complete": player.complete,
            "damage": [one.kind.value for one in player.damage],
            "tactile_unit": "counts" if counts else "Pa",
            "measured": player.measured,
        },
    }


def _value_features(prepared: PreparedScene) -> dict[str, Any]:
    """Return the features of joints and pressures."""
    joints = [joint.name for joint in prepared.robot.joints]
    names = {"observation.tactile": taxel_labels(prepared.skin)}
    features: dict[str, Any] = {
        key: {"dtype": "float32", "shape": [len(names.get(key, joints))], "names": names.get(key, joints)}
        for key in _KEYS
        if names.get(key, joints)
    }
    features["observation.tactile"]["info"] = _places(prepared.skin)
    return features


def _shear_features(prepared: PreparedScene) -> dict[str, Any]:
    """Return the feature of pressure and shear."""
    tangents = np.round(taxel_frames(prepared.map)[:, 0], 6).tolist()
    return {
        _THREE: {
            "dtype": "float32",
            "shape": [len(prepared.skin), 3],
            "names": ["taxel", "axis"],
            "info": {"axes": ["p", "t1", "t2"], "tangents": tangents},
        }
    }


def _window_features(window: int, taxels: int, *, sheared: bool) -> dict[str, Any]:
    """Return the features of windows of this number of readings."""
    padding = {"order": "oldest first", "padding": "the oldest reading, at the front, where the mask is False"}
    features: dict[str, Any] = {
        _WINDOW: {"dtype": "float32", "shape": [window, taxels], "names": ["reading", "taxel"], "info": padding},
        _MASK: {"dtype": "bool", "shape": [window], "names": None},
        _TIME: {"dtype": "float32", "shape": [window], "names": None, "info": {"unit": "s"}},
    }
    if sheared:
        names = ["reading", "taxel", "axis"]
        features[_THREE_WINDOW] = {"dtype": "float32", "shape": [window, taxels, 3], "names": names, "info": padding}
    return features


def _video_feature(size: tuple[int, ...], rate: int) -> dict[str, Any]:
    """Return the feature of the film of the tactile image."""
    return {
        "dtype": "video",
        "shape": [*size, 3],
        "names": ["height", "width", "channels"],
        "info": {
            "video.fps": rate,
            "video.height": size[0],
            "video.width": size[1],
            "video.channels": 3,
            "video.codec": "h264",
            "video.pix_fmt": "yuv420p",
            "video.is_depth_map": False,
            "has_audio": False,
        },
    }
