"""Content of a recording as tables of columns, a few frames at a time, for all formats with tables.

| table | a row for |
|---|---|
| ``recording`` | each fact about the whole: scene, robot, versions, whether it is complete |
| ``damage`` | each loss; no row if nothing is lost |
| ``taxels`` | each taxel: number, hardware id, module, channel (-1 if not stated), patch, link, position, map point |
| ``joints`` | each joint: name and limits |
| ``frames`` | each tick: posture, velocity, command, if there are joints; poses of objects |
| ``pressures`` | each tick: a number for each taxel |
| ``images`` | each tick: the tactile image, on the map at the start of the recording |
| ``contacts`` | each contact region at each tick |
| ``events`` | each contact event from the first frame to the last |
| ``episodes`` | each labelled episode; without any, each run of ticks without a gap, with the scene's name |

In ``contacts``, ``taxels`` is the number of touched taxels, over which ``area``, ``peak`` and ``mean`` are taken (-1
if a recording does not store it); ``force`` also includes the untouched taxels next to them.

Times count from the start of the session, of which a recording or an exported range may be a part: the fact
``begins_s`` in ``recording`` is the time of the first frame. Units are in the columns' names; positions are in the
frame of the link. For a real skin, ``pressures`` also has the sender's time and numbers, and the values as sent
(``raw_counts``, ``raw_Pa`` or ``raw_kPa``; NaN before any). If it was not calibrated, columns in counts replace those
in kPa or Pa, and forces are NaN; if that changed within the recording, there are both, each NaN where it does not
apply.

Of a skin with shear, ``pressures`` also has the tractions along t1 and t2 of each taxel, ``taxels`` these directions in
the frame of the link, and ``contacts`` the wrench on the link: the force of the touching body in the frame of the link,
and its torque about the outward normal at the centre. Tractions and wrenches are missing where no frame has shear, and
NaN in frames without.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.events import ContactEvent
from tactile_maps.core.arrays import BoolArray
from tactile_maps.core.progress import Progress
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.export.contact_messages import contact_wrench
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.taxel_frames import taxel_frames
from tactile_maps.recording.file.damage import damage_text
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin

_LONGEST_GAP = 1.0
"""Longest time without a reading of a real skin within an episode [s]."""
BATCH = 64
"""Number of frames in memory at a time."""
LOOKING = 0.2
"""Share of the progress of an export that ``highest_reading`` takes."""
Columns = Mapping[str, NDArray[Any]]
"""Rows by column; the first axis counts them. Words are arrays of ``str``."""


class Sink(Protocol):
    """Output of tables."""

    def append(self, table: str, columns: Columns) -> None:
        """Add rows to a table; the columns are the same in each call."""


def write_tables(player: RecordingPlayer, sink: Sink, *, image_width: int, progress: Progress) -> None:
    """Write a recording to ``sink``, ``BATCH`` frames at a time.

    Args:
        player: The recording.
        sink: Output of the tables.
        image_width: Length of the tactile image's longer side [px]; 0 for no images.
        progress: Receives a description and the progress; may raise to cancel.
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
    sheared = has_shear(player)
    for frames in batches(player, progress):
        for table, columns in _of_frames(frames, image, units, sheared=sheared).items():
            sink.append(table, columns)


def has_shear(player: RecordingPlayer) -> bool:
    """Return whether any frame of a recording has shear. Cost: the time to read all frames of a three-axis skin."""
    return bool(player.prepared.skin.three_axis.any()) and any(frame.shear is not None for frame in player)


def shear_rows(frames: Sequence[Frame]) -> NDArray[np.float64]:
    """Return the shear (frames, taxels, 2) [Pa], or stored as pressures are; NaN in frames without."""
    return np.stack([np.full((len(one.pressures), 2), np.nan) if one.shear is None else one.shear for one in frames])


def units_of(player: RecordingPlayer) -> tuple[ReadingUnits, ...]:
    """Return all kinds of values among a recording's readings, in the order of the enum; simulated ones are calibrated.

    Cost: for a real skin, the time to read all frames.
    """
    if player.measured is None:
        return (ReadingUnits.CALIBRATED,)
    found = {frame.units for frame in player if frame.measured is None or frame.measured.sent is not None}
    return tuple(units for units in ReadingUnits if units in found) or (ReadingUnits.COUNTS,)


def highest_reading(player: RecordingPlayer, progress: Progress) -> float:
    """Return the highest pressure of a recording [Pa], at least 0. Cost: reads each frame."""
    highest = 0.0
    for number, frame in enumerate(player):
        if number % BATCH == 0:
            progress("Finding the highest reading", number / len(player))
        highest = max(highest, frame.highest_pressure)
    return highest


def batches(player: RecordingPlayer, progress: Progress) -> Iterator[list[Frame]]:
    """Yield the frames of a recording in order, ``BATCH`` at a time, and report progress; a damaged one raises."""
    frames = iter(player)
    done = 0
    while batch := list(islice(frames, BATCH)):
        progress("Exporting", done / len(player))
        yield batch
        done += len(batch)
    progress("Exporting", 1.0)


def paced_frames(
    player: RecordingPlayer, rate: float, progress: Progress
) -> Iterator[tuple[Frame, bool, Sequence[ContactEvent]]]:
    """Yield each frame, whether a picture is due at it, and the contact events since the previous frame.

    Args:
        player: The recording.
        rate: Maximum rate of pictures [Hz].
        progress: Receives a description and the progress; may raise to cancel.
    """
    every = max(round(1.0 / (rate * player.prepared.scene.tick)), 1)
    next_picture = -(-player.frame(0).tick // every) * every
    done = 0
    for frames in batches(player, progress):
        for frame in frames:
            due = frame.tick >= next_picture  # readings of a real skin come at any ticks
            if due:
                next_picture = (frame.tick // every + 1) * every
            known = bisect_right(player.events, frame.tick, key=lambda event: event.tick)
            yield frame, due, player.events[done:known]
            done = known


@dataclass(frozen=True)
class Episode:
    """A run of ticks without a gap.

    Attributes:
        first: Number of its first frame.
        frames: Number of frames.
        label: Label.
        instruction: The task in words; empty if it is not set.
        outcome: ``success``, ``failure`` or empty if it is not set.
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
    """Return the labelled episodes, each without a gap; without any, the runs of ticks.

    A recording is one run, or more if frames are missing, or if a real skin sent nothing for a while.

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
    """Return a unique name for each taxel: ``id_87012`` if its hardware id is known, else ``taxel_12``.

    Ids of several taxels are followed by the taxel's number: ``id_3_taxel_12``.
    """
    ids = [skin.taxel_name(taxel).id for taxel in range(len(skin))]
    known, counts = np.unique([own for own in ids if own is not None], return_counts=True)
    repeated = set(known[counts > 1].tolist())
    return [
        f"taxel_{taxel}" if own is None else f"id_{own}_taxel_{taxel}" if own in repeated else f"id_{own}"
        for taxel, own in enumerate(ids)
    ]


_TAXEL_COLUMNS = ("pressure_Pa", "reading_counts", "raw_counts", "raw_Pa", "raw_kPa", "shear_Pa", "shear_counts")
"""Columns with a number for each taxel; those of shear have the prefix ``t1_`` or ``t2_``."""


def column_labels(prepared: PreparedScene) -> dict[str, Sequence[str]]:
    """Return the label of each number in a row, by column: names of taxels or joints."""
    columns = [f"{part}{name}" for part in ("", "t1_", "t2_") for name in _TAXEL_COLUMNS]
    return {
        **dict.fromkeys(columns, taxel_labels(prepared.skin)),
        **dict.fromkeys(JOINT_COLUMNS, prepared.robot.joint_names),
    }


def row_column(columns: Columns) -> str:
    """Return the name of the column that indexes the rows of a table: the time, or else the first."""
    return "time_s" if "time_s" in columns else next(iter(columns))


def inner_dimensions(column: str, values: NDArray[Any]) -> list[str]:
    """Return the names of the axes of a column after the first one."""
    if column in JOINT_COLUMNS:
        return ["joint"]
    if column.startswith("image_"):
        return ["pixel_row", "pixel_column"]
    if column.removeprefix("t1_").removeprefix("t2_") in _TAXEL_COLUMNS:
        return ["taxel"]
    return [f"{column}_{axis}" for axis in range(1, values.ndim)]


def column_unit(column: str, slides: Sequence[bool] = ()) -> str | list[str] | None:
    """Return the unit of a column's numbers; None if they have none, or several.

    Args:
        column: Name of the column.
        slides: For each joint, whether it slides.

    Returns:
        One unit for each joint if the joints differ.
    """
    if column not in JOINT_UNITS:
        return _SUFFIX_UNITS.get(column.rpartition("_")[2]) if "_" in column else None
    units = [JOINT_UNITS[column][slide] for slide in slides]
    return units if len(set(units)) > 1 else (units or JOINT_UNITS[column])[0]


_SUFFIX_UNITS = {"Pa": "Pa", "kPa": "kPa", "counts": "counts", "s": "s", "m": "m", "m2": "m2", "N": "N", "Nm": "N m"}
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
"""Units for a joint that rotates, and for one that slides."""
JOINT_COLUMNS: Mapping[str, Callable[[Frame], NDArray[np.float64]]] = {
    "position": lambda frame: frame.posture,
    "velocity": lambda frame: frame.velocity,
    "command_position": lambda frame: frame.command.posture,
    "command_stiffness": lambda frame: frame.command.stiffness,
    "command_damping": lambda frame: frame.command.damping,
    "command_torque": lambda frame: frame.command.torque,
}
"""Numbers of each joint [rad, rad/s, rad, Nm/rad, Nms/rad, Nm; for slides with m and N]."""


def taxel_columns(prepared: PreparedScene) -> Columns:
    """Return the table ``taxels``."""
    skin = prepared.skin
    patches = [skin.patches[number] for number in skin.patch_of]
    names = [skin.taxel_name(taxel) for taxel in range(len(skin))]
    return {
        "taxel": np.arange(len(skin)),
        "label": np.array(taxel_labels(skin)),
        "id": _numbers([name.id for name in names]),
        "module": _numbers([name.module for name in names]),
        "channel": _numbers([name.channel for name in names]),
        **({"name": np.array([name.name or "" for name in names])} if any(name.name for name in names) else {}),
        "patch": np.array([patch.name for patch in patches]),
        "link": np.array([patch.link for patch in patches]),
        **{f"{axis}_m": column for axis, column in zip("xyz", skin.positions.T, strict=True)},
        **{f"normal_{axis}": column for axis, column in zip("xyz", skin.normals.T, strict=True)},
        **_tangents(prepared),
        "area_m2": skin.areas,
        "map_x_m": prepared.map.taxel_points[:, 0],
        "map_y_m": prepared.map.taxel_points[:, 1],
    }


def _tangents(prepared: PreparedScene) -> Columns:
    """Return t1 and t2 of three-axis taxels, NaN for others; no columns for a skin without them."""
    measured = prepared.skin.three_axis
    if not measured.any():
        return {}
    frames = np.where(measured[:, None, None], taxel_frames(prepared.map), np.nan)
    return {f"{t}_{axis}": frames[:, row, k] for row, t in enumerate(("t1", "t2")) for k, axis in enumerate("xyz")}


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
        "begins_s": repr(float(player.times[0])),
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
        "joint": _words(prepared.robot.joint_names),
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
    first, last = (round(float(time) / player.prepared.scene.tick) for time in player.times[[0, -1]])
    events = [event for event in player.events if first <= event.tick <= last]
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
    """Return values in pascals, a row for each of ``of``: ``NAME_Pa``, or in counts if they are not pressures."""
    counted = np.array([one is ReadingUnits.COUNTS for one in of], dtype=bool)
    rows = counted.reshape(-1, *[1] * (values.ndim - 1))
    columns: dict[str, NDArray[Any]] = {}
    if set(units) != {ReadingUnits.COUNTS}:
        columns[f"{name}_Pa"] = np.where(rows, np.nan, values) if counted.any() else values
    if ReadingUnits.COUNTS in units:
        columns[f"{counts or name}_counts"] = np.where(rows, 1e-3 * values, np.nan)
    return columns


def _shear(frames: Sequence[Frame], of: Sequence[ReadingUnits], units: Sequence[ReadingUnits]) -> Columns:
    """Return the shear of the taxels along t1 and t2, and what a real skin sent of it."""
    found: dict[str, NDArray[Any]] = {}
    tractions = shear_rows(frames)
    for axis in range(2):
        found.update(_by_unit(f"t{axis + 1}_shear", tractions[:, :, axis], of, units))
    known = [frame.measured for frame in frames if frame.measured is not None]
    if len(known) < len(frames):
        return found
    missing = np.full(tractions.shape[1:], np.nan)
    sent = np.stack([missing if one.raw_shear is None else one.raw_shear for one in known])
    return found | {f"t{axis + 1}_raw_{known[-1].unit}": sent[:, :, axis] for axis in range(2)}


def _sent(frames: Sequence[Frame]) -> Columns:
    """Return the values that a real skin sent; empty for a simulated one."""
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
    frames: Sequence[Frame], image: TactileImage | None, units: Sequence[ReadingUnits], *, sheared: bool
) -> dict[str, Columns]:
    """Return the tables of some ticks."""
    when = {"tick": np.array([frame.tick for frame in frames]), "time_s": np.array([frame.time for frame in frames])}
    joints = len(frames[0].posture)
    rows = {name: np.stack([part(frame) for frame in frames]) for name, part in JOINT_COLUMNS.items() if joints}
    objects = np.stack([frame.objects for frame in frames])
    if objects.size:
        rows["objects_pose"] = objects.reshape(len(frames), -1)
    of = [frame.units for frame in frames]
    tables: dict[str, Columns] = {
        "frames": {**when, **rows},
        "pressures": {
            **when,
            **_by_unit(
                "pressure",
                np.stack([frame.pressures for frame in frames]),
                of,
                units,
                counts="reading",
            ),
            **_sent(frames),
            **(_shear(frames, of, units) if sheared else {}),
        },
        "contacts": _contacts(frames, units, sheared=sheared),
    }
    if image is not None:
        tables["images"] = {**when, **_images(frames, image, units)}
    return tables


def _images(frames: Sequence[Frame], image: TactileImage, units: Sequence[ReadingUnits]) -> Columns:
    """Return pixels in kPa, or in counts."""
    pixels = np.stack([image.render(frame.pressures) for frame in frames])
    found = _by_unit("image", pixels, [frame.units for frame in frames], units)
    return {
        "image_kPa" if name == "image_Pa" else name: values if name == "image_Pa" else 1e3 * values
        for name, values in found.items()
    }


def _wrenches(regions: Sequence[ContactRegion], claimed: BoolArray) -> Columns:
    """Return the wrenches of contacts and the state of their friction; NaN without shear, or without units of force."""
    known = claimed & np.array([one.shear is not None for one in regions], dtype=bool)
    wrenches = np.array([contact_wrench(one).wrench for one in regions], dtype=np.float64).reshape(-1, 6)
    names = [f"{part}_{axis}_{unit}" for part, unit in (("force", "N"), ("torque", "Nm")) for axis in "xyz"]
    found = {name: np.where(known, column, np.nan) for name, column in zip(names, wrenches.T, strict=True)}
    usage = np.array([np.nan if one.shear is None else one.shear.usage for one in regions], dtype=np.float64)
    slip = _words(["" if one.shear is None else one.shear.slip.value for one in regions])
    return {**found, "friction_usage": usage, "slip": slip}


def _contacts(frames: Sequence[Frame], units: Sequence[ReadingUnits], *, sheared: bool) -> Columns:
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
    columns["partner"] = _numbers([region.partner for _, region in rows])
    return {**columns, **(_wrenches([region for _, region in rows], claimed) if sheared else {})}
