"""What a recording holds as tables of columns, a few frames at a time: the same for every format that is tables.

| table | a row for |
|---|---|
| ``recording`` | each fact about the whole: scene, robot, versions, whether it is complete |
| ``damage`` | each thing that it has lost; no row where nothing is |
| ``taxels`` | each taxel: number, hardware id, module, channel (-1 where not stated), patch, link, place, map point |
| ``joints`` | each joint: name and limits |
| ``frames`` | each tick: posture, velocity, command, where there are joints; poses of objects |
| ``pressures`` | each tick: a number for each taxel |
| ``images`` | each tick: the tactile image, on the map that the recording began with |
| ``contacts`` | each contact region at each tick |
| ``events`` | each contact event |
| ``episodes`` | each labelled episode; where there is none each run of ticks without a gap, with the scene's name |

In ``contacts``, ``taxels`` is the number of touched taxels, over which ``area``, ``peak`` and ``mean`` are taken (-1
where a recording does not store it); ``force`` also includes the untouched taxels next to them.

Units stand in the columns' names; places are in the frame of the link. Of a real skin ``pressures`` has the sender's
time and numbers too, and the values as they were sent (``raw_counts``, ``raw_Pa`` or ``raw_kPa``; NaN before any).
Where it was not calibrated, the columns in kPa or Pa give way to such in counts, and forces are NaN; where that changed
within the recording there are both, each NaN where it does not apply.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.progress import Progress
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.recording.file.damage import damage_text
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin

_LONGEST_GAP = 1.0
"""Seconds without a reading of a real skin that do not end an episode."""
BATCH = 64
"""Frames in memory at a time."""
LOOKING = 0.2
"""Share of an export that ``highest_reading`` takes before it, where one is needed."""
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
    units = units_of(player)
    for frames in batches(player, progress):
        for table, columns in _of_frames(frames, image, units).items():
            sink.append(table, columns)


def units_of(player: RecordingPlayer) -> tuple[ReadingUnits, ...]:
    """All that the readings of a recording may be called, in the order of the enum; of a simulated one that is known.

    Cost: as to read all frames of a real skin.
    """
    if player.measured is None:
        return (ReadingUnits.CALIBRATED,)
    found = {frame.units for frame in player if frame.measured is None or frame.measured.sent is not None}
    return tuple(units for units in ReadingUnits if units in found) or (ReadingUnits.COUNTS,)


def highest_reading(player: RecordingPlayer, progress: Progress) -> float:
    """The greatest of a recording's pressures [Pa], 0 at least. Cost: each frame is read."""
    highest = 0.0
    for number, frame in enumerate(player):
        if number % BATCH == 0:
            progress("Finding the highest reading", number / len(player))
        highest = max(highest, float(np.nanmax(frame.pressures, initial=0.0)))
    return highest


def batches(player: RecordingPlayer, progress: Progress, *, size: int = BATCH) -> Iterator[list[Frame]]:
    """The frames of a recording in order, ``size`` at a time, with progress between; a damaged one raises."""
    frames = iter(player)
    done = 0
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
        instruction: What was to be done, in words; empty where nobody says.
        outcome: ``success``, ``failure`` or empty where nobody says.
    """

    first: int
    frames: int
    label: str
    instruction: str = ""
    outcome: str = ""

    @property
    def task(self) -> str:
        """The instruction, or else the label."""
        return self.instruction or self.label


def episodes(player: RecordingPlayer) -> list[Episode]:
    """The episodes that a person labelled, each without a gap; where there is none, the runs of ticks.

    A recording is one run, or more where frames are missing; of a real skin, where it fell silent.

    Raises:
        RecordingError: The file with the labels is damaged.
    """
    runs = _runs(player)
    ticks = np.rint(player.times / player.prepared.scene.tick).astype(np.int64)
    found = []
    for one in player.annotations().episodes:
        first, end = np.searchsorted(ticks, (one.first, one.last + 1)).tolist()
        for run in runs:
            begin = max(first, run.first)
            until = min(end, run.first + run.frames)
            if until > begin:
                found.append(Episode(begin, until - begin, one.label, one.instruction, str(one.outcome or "")))
    return found or runs


def _runs(player: RecordingPlayer) -> list[Episode]:
    if player.measured is None:
        ticks = np.rint(player.times / player.prepared.scene.tick).astype(np.int64)
        apart = np.diff(ticks) != 1
    else:  # readings come at any ticks
        steps = np.diff(player.times)
        apart = steps > max(_LONGEST_GAP, 10 * float(np.median(steps))) if len(steps) else np.zeros(0, dtype=bool)
    starts = [0, *(np.flatnonzero(apart) + 1).tolist()]
    return [
        Episode(start, end - start, player.prepared.scene.name)
        for start, end in zip(starts, [*starts[1:], len(player)], strict=True)
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
    columns = ("pressure_Pa", "reading_counts", "raw_counts", "raw_Pa", "raw_kPa")
    return {**dict.fromkeys(columns, taxel_labels(prepared.skin)), **dict.fromkeys(JOINT_COLUMNS, joints)}


def row_column(columns: Columns) -> str:
    """Name of the column that the rows of a table are counted by: the time, else the first."""
    return "time_s" if "time_s" in columns else next(iter(columns))


def inner_dimensions(column: str, values: NDArray[Any]) -> list[str]:
    """Names of the axes of a column behind the first one: what its numbers in a row are of."""
    if column in JOINT_COLUMNS:
        return ["joint"]
    if column.startswith("image_"):
        return ["pixel_row", "pixel_column"]
    if column.startswith(("pressure_", "reading_", "raw_")):
        return ["taxel"]
    return [f"{column}_{axis}" for axis in range(1, values.ndim)]


def column_unit(column: str, slides: Sequence[bool] = ()) -> str | list[str] | None:
    """Unit of a column's numbers; None where they have none, or several.

    Args:
        column: Name of the column.
        slides: For each joint, whether it slides.

    Returns:
        One unit for each joint where the joints differ.
    """
    if column not in JOINT_UNITS:
        return _SUFFIX_UNITS.get(column.rpartition("_")[2]) if "_" in column else None
    units = [JOINT_UNITS[column][slide] for slide in slides]
    return units if len(set(units)) > 1 else (units or JOINT_UNITS[column])[0]


_SUFFIX_UNITS = {"Pa": "Pa", "kPa": "kPa", "counts": "counts", "s": "s", "m": "m", "m2": "m2", "N": "N"}
JOINT_UNITS = {
    "position": ("rad", "m"),
    "velocity": ("rad/s", "m/s"),
    "command_position": ("rad", "m"),
    "command_stiffness": ("N m/rad", "N/m"),
    "command_damping": ("N m s/rad", "N s/m"),
    "command_torque": ("N m", "N"),
    "lower": ("rad", "m"),
    "upper": ("rad", "m"),
}
"""Units of the numbers of a joint that turns, and of one that slides."""
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
        **({"name": np.array([name.name or "" for name in names])} if any(name.name for name in names) else {}),
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
    found = player.damage
    tick = player.prepared.scene.tick
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
        "instruction": _words([one.instruction for one in found]),
        "outcome": _words([one.outcome for one in found]),
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
        "force_N": np.array([np.nan if event.force is None else event.force for event in events], dtype=np.float64),
        "duration_s": np.array([event.duration for event in events], dtype=np.float64),
        "travelled_m": np.array([event.travelled for event in events], dtype=np.float64),
        "words": _words([event.words for event in events]),
    }


def _by_unit(
    name: str,
    values: NDArray[Any],
    of: Sequence[ReadingUnits],
    units: Sequence[ReadingUnits],
    *,
    counts: str = "",
) -> Columns:
    """Values in pascals, a row for each of ``of``: ``NAME_Pa``, or in counts where they are no pressures."""
    counted = np.array([one is ReadingUnits.COUNTS for one in of], dtype=bool)
    rows = counted.reshape(-1, *[1] * (values.ndim - 1))
    columns: dict[str, NDArray[Any]] = {}
    if set(units) != {ReadingUnits.COUNTS}:
        columns[f"{name}_Pa"] = np.where(rows, np.nan, values) if counted.any() else values
    if ReadingUnits.COUNTS in units:
        columns[f"{counts or name}_counts"] = np.where(rows, 1e-3 * values, np.nan)
    return columns


def _sent(frames: Sequence[Frame]) -> Columns:
    """What a real skin sent; nothing of a simulated one."""
    sent = [frame.measured for frame in frames]
    known = [one for one in sent if one is not None]
    if len(known) < len(sent):
        return {}
    return {
        "sent_s": np.array([np.nan if one.sent is None else one.sent for one in known]),
        "sequence": _numbers([one.sequence for one in known]),
        f"raw_{known[-1].unit}": np.stack([one.raw for one in known]),
    }


def _of_frames(
    frames: Sequence[Frame], image: TactileImage | None, units: Sequence[ReadingUnits]
) -> dict[str, Columns]:
    """The tables of ticks, for some of them."""
    when = {"tick": np.array([frame.tick for frame in frames]), "time_s": np.array([frame.time for frame in frames])}
    joints = len(frames[0].posture)
    rows = {name: np.stack([part(frame) for frame in frames]) for name, part in JOINT_COLUMNS.items() if joints}
    objects = np.stack([frame.objects for frame in frames])
    if objects.size:
        rows["objects_pose"] = objects.reshape(len(frames), -1)
    tables: dict[str, Columns] = {
        "frames": {**when, **rows},
        "pressures": {
            **when,
            **_by_unit(
                "pressure",
                np.stack([frame.pressures for frame in frames]),
                [frame.units for frame in frames],
                units,
                counts="reading",
            ),
            **_sent(frames),
        },
        "contacts": _contacts(frames, units),
    }
    if image is not None:
        tables["images"] = {**when, **_images(frames, image, units)}
    return tables


def _images(frames: Sequence[Frame], image: TactileImage, units: Sequence[ReadingUnits]) -> Columns:
    """Pixels in kPa, or in counts."""
    pixels = np.stack([image.render(frame.pressures) for frame in frames])
    found = _by_unit("image", pixels, [frame.units for frame in frames], units)
    return {
        "image_kPa" if name == "image_Pa" else name: values if name == "image_Pa" else 1e3 * values
        for name, values in found.items()
    }


def _contacts(frames: Sequence[Frame], units: Sequence[ReadingUnits]) -> Columns:
    rows = [(frame, region) for frame in frames for region in frame.regions]

    def vector(name: str, length: int) -> NDArray[np.float64]:
        return np.array([getattr(region, name) for _, region in rows], dtype=np.float64).reshape(-1, length)

    def number(name: str) -> NDArray[np.float64]:
        return np.array([getattr(region, name) for _, region in rows], dtype=np.float64)

    of = [frame.units for frame, _ in rows]
    claimed = np.array([one.force is not None for one in of], dtype=bool)
    intervals = np.array([region.force_interval for _, region in rows], dtype=np.float64).reshape(-1, 2)
    columns: dict[str, NDArray[Any]] = {
        "tick": _numbers([frame.tick for frame, _ in rows]),
        "time_s": np.array([frame.time for frame, _ in rows], dtype=np.float64),
        "contact": _numbers([region.id for _, region in rows]),
        "link": _words([region.link for _, region in rows]),
        "taxels": _numbers([region.touched for _, region in rows]),
        "force_N": np.where(claimed, number("force"), np.nan),
        "force_error_N": np.where(claimed, number("force_error"), np.nan),
        "force_low_N": np.where(claimed, intervals[:, 0], np.nan),
        "force_high_N": np.where(claimed, intervals[:, 1], np.nan),
        "place_error_m": number("place_error"),
        "area_m2": number("area"),
        **_by_unit("peak", number("peak"), of, units),
        **_by_unit("mean", number("mean"), of, units),
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
