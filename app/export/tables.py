"""What a recording holds as tables of columns, a few frames at a time: the same for every format that is tables.

| table | a row for |
|---|---|
| ``recording`` | each fact about the whole: scene, robot, versions, whether it is complete |
| ``damage`` | each thing that it has lost; no row where nothing is |
| ``taxels`` | each taxel: number, hardware id, module, channel (-1 where not stated), patch, link, place, map point |
| ``joints`` | each joint: name and limits |
| ``frames`` | each tick: posture, velocity, command; poses of objects |
| ``pressures`` | each tick: a number for each taxel |
| ``images`` | each tick: the tactile image, on the map that the recording began with |
| ``contacts`` | each contact region at each tick |
| ``events`` | each contact event |
| ``episodes`` | each run of ticks without a gap, with the scene's name as label |

Units stand in the columns' names; places are in the frame of the link.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from app.core.progress import Progress
from app.maps.tactile_image import TactileImage
from app.recording.damage import damage_text
from app.recording.player import RecordingPlayer
from app.session.frame import Frame
from app.session.prepare import PreparedScene
from app.skin.skin import Skin

BATCH = 64
"""Frames in memory at a time."""
Columns = Mapping[str, NDArray[Any]]
"""Rows by column; the first axis counts them. Words are arrays of ``str``."""


class Sink(Protocol):
    """Where tables go."""

    def append(self, table: str, columns: Columns) -> None:
        """More rows of a table; the columns are the same each time."""


def write_tables(player: RecordingPlayer, sink: Sink, *, image_width: int, progress: Progress) -> None:
    """Give all of a recording to ``sink``, ``BATCH`` frames at a time.

    Args:
        player: The recording.
        sink: Takes the tables.
        image_width: Pixels of the tactile image on its longer side; 0 for no images.
        progress: Told how far it is; may raise to cancel.
    """
    prepared = player.prepared
    for table, columns in (
        ("recording", _facts(player)),
        ("damage", _damage(player)),
        ("taxels", taxel_columns(prepared)),
        ("joints", _joints(prepared)),
        ("episodes", _episodes(player)),
        ("events", _events(player)),
    ):
        sink.append(table, columns)
    image = TactileImage(prepared.map, width=image_width) if image_width else None
    for frames in batches(player, progress):
        for table, columns in _of_frames(frames, image).items():
            sink.append(table, columns)


def batches(player: RecordingPlayer, progress: Progress, *, size: int = BATCH) -> Iterator[list[Frame]]:
    """The frames of a recording in order, ``size`` at a time, with progress between; a damaged one raises."""
    frames, done = iter(player), 0
    while batch := list(islice(frames, size)):
        progress("Exporting", done / len(player))
        yield batch
        done += len(batch)
    progress("Exporting", 1.0)


@dataclass(frozen=True)
class Episode:
    """A run of ticks without a gap.

    Attributes:
        first: Number of its first frame.
        frames: How many.
        label: What it is about.
    """

    first: int
    frames: int
    label: str


def episodes(player: RecordingPlayer) -> list[Episode]:
    """The runs of ticks of a recording: one, or more where frames are missing."""
    ticks = np.rint(player.times / player.prepared.scene.tick).astype(np.int64)
    starts = [0, *(np.flatnonzero(np.diff(ticks) != 1) + 1).tolist()]
    return [
        Episode(start, end - start, player.prepared.scene.name)
        for start, end in zip(starts, [*starts[1:], len(ticks)], strict=True)
    ]


def taxel_labels(skin: Skin) -> list[str]:
    """A name for each taxel, all different: ``id_87012`` where its hardware id is stated, else ``taxel_12``.

    Ids that several taxels have get the taxel's number too: ``id_3_taxel_12``.
    """
    ids = [skin.taxel_name(taxel).id for taxel in range(len(skin))]
    known, counts = np.unique([own for own in ids if own is not None], return_counts=True)
    repeated = set(known[counts > 1].tolist())
    return [
        f"taxel_{taxel}" if own is None else f"id_{own}_taxel_{taxel}" if own in repeated else f"id_{own}"
        for taxel, own in enumerate(ids)
    ]


def column_labels(prepared: PreparedScene) -> dict[str, Sequence[str]]:
    """What the numbers of a column with several in a row are of: of a taxel, of a joint."""
    joints = [joint.name for joint in prepared.robot.joints]
    return {"pressure_Pa": taxel_labels(prepared.skin), **dict.fromkeys(JOINT_COLUMNS, joints)}


JOINT_COLUMNS: Mapping[str, Callable[[Frame], NDArray[np.float64]]] = {
    "position": lambda frame: frame.posture,
    "velocity": lambda frame: frame.velocity,
    "command_position": lambda frame: frame.command.posture,
    "command_stiffness": lambda frame: frame.command.stiffness,
    "command_damping": lambda frame: frame.command.damping,
    "command_torque": lambda frame: frame.command.torque,
}
"""Of each joint [rad, rad/s, rad, Nm/rad, Nms/rad, Nm; of slides m and N]."""


def taxel_columns(prepared: PreparedScene) -> Columns:
    """The table ``taxels``."""
    skin = prepared.skin
    patches = [skin.patches[number] for number in skin.patch_of]
    names = [skin.taxel_name(taxel) for taxel in range(len(skin))]
    positions = np.concatenate([patch.taxels.positions for patch in skin.patches])
    normals = np.concatenate([patch.taxels.normals for patch in skin.patches])
    return {
        "taxel": np.arange(len(skin)),
        "label": np.array(taxel_labels(skin)),
        "id": _numbers([name.id for name in names]),
        "module": _numbers([name.module for name in names]),
        "channel": _numbers([name.channel for name in names]),
        "patch": np.array([patch.name for patch in patches]),
        "link": np.array([patch.link for patch in patches]),
        **{f"{axis}_m": column for axis, column in zip("xyz", positions.T, strict=True)},
        **{f"normal_{axis}": column for axis, column in zip("xyz", normals.T, strict=True)},
        "area_m2": skin.areas,
        "map_x_m": prepared.map.taxel_points[:, 0],
        "map_y_m": prepared.map.taxel_points[:, 1],
    }


def _numbers(values: Sequence[int | None]) -> NDArray[np.int64]:
    return np.array([-1 if value is None else value for value in values], dtype=np.int64)


def _words(values: Sequence[str]) -> NDArray[np.str_]:
    return np.array(values, dtype=np.str_)


def _facts(player: RecordingPlayer) -> Columns:
    scene = player.prepared.scene
    facts = {
        "scene": scene.name,
        "robot": player.prepared.robot.name,
        "tick_s": repr(scene.tick),
        "frames": str(len(player)),
        "complete": "yes" if player.complete else "no",
        **{name: text for name, text in player.versions.items() if name not in ("tick_s", "damage")},
    }
    return {"fact": _words(list(facts)), "value": _words(list(facts.values()))}


def _damage(player: RecordingPlayer) -> Columns:
    found, tick = player.damage, player.prepared.scene.tick
    return {
        "kind": _words([one.kind.value for one in found]),
        "count": _numbers([one.count for one in found]),
        "first_tick": _numbers([one.first for one in found]),
        "last_tick": _numbers([one.last for one in found]),
        "words": _words([damage_text(one, tick) for one in found]),
    }


def _joints(prepared: PreparedScene) -> Columns:
    joints = prepared.robot.joints
    return {
        "joint": _words([joint.name for joint in joints]),
        "lower": np.array([float(joint.lower) for joint in joints]),
        "upper": np.array([float(joint.upper) for joint in joints]),
        "slide": np.array([joint.slide for joint in joints], dtype=np.int64),
    }


def _episodes(player: RecordingPlayer) -> Columns:
    found = episodes(player)
    return {
        "episode": np.arange(len(found)),
        "first_frame": _numbers([one.first for one in found]),
        "frames": _numbers([one.frames for one in found]),
        "start_s": np.array([float(player.times[one.first]) for one in found]),
        "label": _words([one.label for one in found]),
    }


def _events(player: RecordingPlayer) -> Columns:
    events = player.events
    return {
        "tick": _numbers([event.tick for event in events]),
        "time_s": np.array([event.time for event in events], dtype=np.float64),
        "kind": _words([event.kind for event in events]),
        "phase": _words([event.phase for event in events]),
        "contacts": _words([" ".join(map(str, event.contacts)) for event in events]),
        "links": _words([" ".join(event.links) for event in events]),
        "force_N": np.array([event.force for event in events], dtype=np.float64),
        "duration_s": np.array([event.duration for event in events], dtype=np.float64),
        "travelled_m": np.array([event.travelled for event in events], dtype=np.float64),
        "words": _words([event.words for event in events]),
    }


def _of_frames(frames: Sequence[Frame], image: TactileImage | None) -> dict[str, Columns]:
    """The tables of ticks, for some of them."""
    when = {"tick": np.array([frame.tick for frame in frames]), "time_s": np.array([frame.time for frame in frames])}
    rows = {name: np.stack([part(frame) for frame in frames]) for name, part in JOINT_COLUMNS.items()}
    objects = np.stack([frame.objects for frame in frames])
    if objects.size:
        rows["objects_pose"] = objects.reshape(len(frames), -1)
    tables: dict[str, Columns] = {
        "frames": {**when, **rows},
        "pressures": {**when, "pressure_Pa": np.stack([frame.pressures for frame in frames])},
        "contacts": _contacts(frames),
    }
    if image is not None:
        tables["images"] = {**when, "image_kPa": np.stack([image.render(frame.pressures) for frame in frames])}
    return tables


def _contacts(frames: Sequence[Frame]) -> Columns:
    rows = [(frame, region) for frame in frames for region in frame.regions]

    def vector(name: str, length: int) -> NDArray[np.float64]:
        return np.array([getattr(region, name) for _, region in rows], dtype=np.float64).reshape(-1, length)

    def number(name: str) -> NDArray[np.float64]:
        return np.array([getattr(region, name) for _, region in rows], dtype=np.float64)

    columns: dict[str, NDArray[Any]] = {
        "tick": _numbers([frame.tick for frame, _ in rows]),
        "time_s": np.array([frame.time for frame, _ in rows], dtype=np.float64),
        "contact": _numbers([region.id for _, region in rows]),
        "link": _words([region.link for _, region in rows]),
        "taxels": _numbers([len(region.taxels) for _, region in rows]),
        "force_N": number("force"),
        "force_error_N": number("force_error"),
        "place_error_m": number("place_error"),
        "area_m2": number("area"),
        "peak_Pa": number("peak"),
        "mean_Pa": number("mean"),
    }
    for name, part, axes in (
        ("", "link_position", "xyz"),
        ("normal_", "link_normal", "xyz"),
        ("map_", "map_point", "xy"),
    ):
        unit = "" if name == "normal_" else "_m"
        values = vector(part, len(axes))
        columns |= {f"{name}{axis}{unit}": column for axis, column in zip(axes, values.T, strict=True)}
    return columns | {"partner": _numbers([region.partner for _, region in rows])}
