"""Touches at known places, to find where a patch really is: a CSV table, or a trajectory and a file of readings.

A table has the columns ``x``, ``y``, ``z`` [m] (or ``x_mm``, ...) of the place that was touched, in the frame in which
the taxels are stated, optionally ``link``, and one column for each taxel, by id (``87012``, ``l_hand:12``) or module
and channel (``14.3``). Rows without a place are readings of the untouched skin.

Where another link of the robot touches, the column ``touching_link`` names it. The place is then the point of contact
in the frame of that link, and a column ``joint:NAME`` states the position [rad or m] of each joint between both links.

A trajectory has ``time`` [s] and the place, for example of the tip of another arm, and no columns of taxels. The
readings come from any file of readings with the same clock; those outside the trajectory are of the untouched skin.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.core.errors import LiveError, did_you_mean
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.live.calibration.calibration_log import PLACE_COLUMN, TAXEL_CHANNEL, TAXEL_ID
from tactile_maps.live.readings.joint_range import plausible_range
from tactile_maps.live.readings.readings import Reading, SourceEndedError
from tactile_maps.live.readings.tables import decimal_number, missing_column, read_cells
from tactile_maps.live.sources.open import SourceOptions, open_source
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot
from tactile_maps.skin.model.taxel_set import TaxelSet

_NOISE = 3.0
"""Readings count above this many standard deviations of those of the untouched skin."""
_TOUCHING = "touching_link"
_JOINT = "joint:"
_GAP = 0.5
"""Largest time between two places of a trajectory between which the place is interpolated [s]."""


@dataclass(frozen=True, eq=False)
class TouchLog(ArrayFields, places=3):
    """Touches at known places.

    Attributes:
        places: (t, 3) places [m], in the frame of the taxels.
        changes: (t, n) changes of the readings from the untouched skin, positive under pressure; NaN for taxels that
            did not report.
        noise: (n,) changes that noise may cause.
        elsewhere: Names of other links in the table, each once. Their rows are left out.
    """

    places: FloatArray
    changes: FloatArray
    noise: FloatArray
    elsewhere: tuple[str, ...] = ()


def read_touch_log(
    path: str | Path,
    taxels: TaxelSet,
    *,
    robot: Robot | None = None,
    readings: str | Path | None = None,
    changes: bool = False,
) -> TouchLog:
    """Read touches of one set of taxels.

    Args:
        path: The table of touches, or the trajectory if ``readings`` is given.
        taxels: The taxels; with a robot, in the frame of their link.
        robot: The robot, if links of it touch the taxels.
        readings: File of readings with the clock of the trajectory.
        changes: Whether the readings are changes from the untouched skin, so that none of it are needed.

    Raises:
        LiveError: A file cannot be read, a column is unknown or missing, or no reading of the untouched skin is known.
        RobotError: The robot does not have the link of the taxels.
    """
    file = Path(path)
    (_, header), *rows = read_cells(file)
    places = _places(header, rows, file)
    elsewhere = _elsewhere(header, rows, taxels.link)
    places[[name != "" for name in elsewhere]] = np.nan
    if robot is not None:
        places = _on_touched_link(file, header, rows, places, taxels, robot)
    elif _TOUCHING in (word.lower() for word in header):
        remedy = "Name the robot that touches itself (--robot)"
        raise LiveError("the place of a touching link needs a robot", file=file, place="header", remedy=remedy)
    kept = [at for at, name in enumerate(elsewhere) if not name]
    rows, places = [rows[at] for at in kept], places[kept]
    if readings is not None:
        places, values = _along_trajectory(file, header, rows, places, Path(readings), taxels)
    else:
        values = _table_values(file, header, rows, taxels)
    touched = np.isfinite(places).all(axis=1)
    free = values[~touched]
    if not changes and not len(free):
        remedy = "Add rows without a place, or readings outside the trajectory, or state --changes"
        raise LiveError("no reading of the untouched skin", file=file, remedy=remedy)
    there = ~np.isnan(free)
    counted = np.where(there, free, 0.0)
    counts = np.maximum(there.sum(axis=0), 1)
    mean = np.zeros(len(taxels)) if changes else counted.sum(axis=0) / counts
    spread = (
        np.zeros(len(taxels)) if changes else np.sqrt((np.where(there, free - mean, 0.0) ** 2).sum(axis=0) / counts)
    )
    change = values[touched] - mean
    sign = -1.0 if np.nansum(np.where(np.abs(change) > _NOISE * spread, change, 0.0)) < 0 else 1.0
    return TouchLog(places[touched], sign * change, _NOISE * spread, tuple(dict.fromkeys(filter(None, elsewhere))))


def _elsewhere(header: Sequence[str], rows: Sequence[tuple[int, Sequence[str]]], link: str | None) -> list[str]:
    """Return the link of each row that is on another link than this, and an empty text for the others."""
    names = [word.lower() for word in header]
    if "link" not in names or link is None:
        return [""] * len(rows)
    named = [cells[names.index("link")] for _, cells in rows]
    return ["" if name == link else name for name in named]


def _places(header: Sequence[str], rows: Sequence[tuple[int, Sequence[str]]], path: Path) -> FloatArray:
    """Return the places (rows, 3) [m]; NaN for rows without one."""
    found = {
        match[1]: (at, match[2]) for at, word in enumerate(header) if (match := PLACE_COLUMN.fullmatch(word.lower()))
    }
    if missing := set("xyz") - found.keys():
        remedy = "The header needs x, y, z [m], or x_mm, y_mm, z_mm"
        raise missing_column(min(missing), header, path, remedy)
    columns = [found[axis] for axis in "xyz"]
    places = np.array(
        [[decimal_number(cells[at], path, line, header[at]) for at, _ in columns] for line, cells in rows]
    )
    return np.asarray(places.reshape(-1, 3) * [1e-3 if unit == "mm" else 1.0 for _, unit in columns])


def _on_touched_link(
    path: Path,
    header: Sequence[str],
    rows: Sequence[tuple[int, Sequence[str]]],
    points: FloatArray,
    taxels: TaxelSet,
    robot: Robot,
) -> FloatArray:
    """Return the places (rows, 3) [m] on the touched link of points (rows, 3) in the frames of the touching links."""
    names = [word.lower() for word in header]
    if _TOUCHING not in names:
        remedy = "Name the link of the robot that touches, or omit --robot"
        raise missing_column(_TOUCHING, header, path, remedy)
    joints = {word.removeprefix(_JOINT): at for at, word in enumerate(header) if word.startswith(_JOINT)}
    configuration = Configuration(robot)
    places = np.full_like(points, np.nan)
    for number, (line, cells) in enumerate(rows):
        row = dict(zip(names, cells, strict=True))
        try:
            _check_links(row, robot)
            if np.isfinite(points[number]).all():
                posture = {name: decimal_number(cells[at], path, line, header[at]) for name, at in joints.items()}
                on_touched = _touching_pose(row[_TOUCHING], taxels.link or "", posture, robot, configuration)
                places[number] = on_touched.points(points[number])
        except LiveError as error:
            raise error.at(file=path, place=error.place if error.file else f"line {line}, {error.place}") from error
    return places


def _check_links(row: Mapping[str, str], robot: Robot) -> None:
    """Reject names of links that the robot does not have."""
    for column in ("link", _TOUCHING):
        word = row.get(column)
        if word and word not in robot.link_index:
            raise LiveError(
                "unknown link", place=column, value=word, remedy=did_you_mean(word, tuple(robot.link_index))
            )


def _touching_pose(
    link: str, touched: str, posture: Mapping[str, float], robot: Robot, configuration: Configuration
) -> Pose:
    """Return ``T_touched_link`` at a posture: positions by joint [rad or m], at least of those between both links."""
    if not link:
        remedy = "Name the link that touches, or leave x, y, z empty for a reading of the untouched skin"
        raise LiveError("a place has no touching link", place=_TOUCHING, remedy=remedy)
    before, others = (set(configuration.joints_before(one).tolist()) for one in (touched, link))
    between = sorted(before ^ others)
    if not between:
        remedy = f"Touch with a link that a joint moves relative to {touched}"
        problem = "no joint is between the touching and the touched link"
        raise LiveError(problem, place=_TOUCHING, value=link, remedy=remedy)
    if missing := [robot.joints[number].name for number in between if robot.joints[number].name not in posture]:
        remedy = f"Add {_JOINT}NAME [rad or m] for each joint between {touched} and {link}"
        raise LiveError("columns of joints are missing", place=_TOUCHING, value=", ".join(missing), remedy=remedy)
    positions = robot.home.copy()
    for number in between:
        joint = robot.joints[number]
        positions[number] = posture[joint.name]
        low, high = plausible_range(joint)
        if not low <= positions[number] <= high:
            remedy = f"State {joint.lower:.4g} to {joint.upper:.4g} {'m' if joint.slide else 'rad'}"
            problem = "the joint position is missing or out of range"
            raise LiveError(problem, place=_JOINT + joint.name, value=positions[number], remedy=remedy)
    configuration.update(positions)
    return configuration.pose(touched).inverse @ configuration.pose(link)


def _table_values(
    path: Path, header: Sequence[str], rows: Sequence[tuple[int, Sequence[str]]], taxels: TaxelSet
) -> FloatArray:
    """Return the readings (rows, taxels) of a table with a column for each taxel."""
    known = _labels(taxels)
    names = [word.removeprefix(f"{taxels.link}:") for word in header]
    columns = {at: known[name] for at, name in enumerate(names) if name in known}
    unknown = [
        word
        for at, word in enumerate(header)
        if at not in columns and (TAXEL_ID.fullmatch(word) or TAXEL_CHANNEL.fullmatch(word)) and ":" not in word
    ]
    if unknown or not columns:
        problem = "columns name unknown taxels" if unknown else "no column names a taxel"
        remedy = "Name the columns by the ids of the file, or give the readings as a file of their own (--readings)"
        raise LiveError(problem, file=path, place="header", value=", ".join(unknown) or None, remedy=remedy)
    values = np.full((len(rows), len(taxels)), np.nan)
    for number, (line, cells) in enumerate(rows):
        for at, taxel in columns.items():
            values[number, taxel] = decimal_number(cells[at], path, line, header[at])
    return values


def _along_trajectory(
    path: Path,
    header: Sequence[str],
    rows: Sequence[tuple[int, Sequence[str]]],
    places: FloatArray,
    readings: Path,
    taxels: TaxelSet,
) -> tuple[FloatArray, FloatArray]:
    """Return the interpolated place (m, 3) of each reading, NaN outside the trajectory, and the readings (m, n)."""
    names = [word.lower() for word in header]
    if "time" not in names:
        raise missing_column("time", header, path, "State times in seconds")
    at = names.index("time")
    there = np.isfinite(places).all(axis=1)
    times = np.array([decimal_number(cells[at], path, line, "time") for line, cells in rows])[there]
    places = places[there]
    if len(times) < 2 or not (np.diff(times) > 0).all():
        raise LiveError("the times of a trajectory do not increase", file=path, place="time")
    when, values = _all_readings(readings, taxels)
    after = np.clip(np.searchsorted(times, when), 1, len(times) - 1)
    inside = (when >= times[0]) & (when <= times[-1]) & (times[after] - times[after - 1] <= _GAP)
    along = np.column_stack([np.interp(when, times, coordinate) for coordinate in places.T])
    along[~inside] = np.nan
    return along, values


def _all_readings(path: Path, taxels: TaxelSet) -> tuple[FloatArray, FloatArray]:
    """Return times (m,) [s] and values (m, taxels) of a file of readings; the last value of a taxel is kept."""
    known = _labels(taxels)
    source = open_source(str(path), SourceOptions(speed=None))
    times = list[float]()
    values = list[FloatArray]()
    newest = np.full(len(taxels), np.nan)
    source.open()
    try:
        while True:
            reading = source.receive(0.0)
            if reading is None:
                continue
            newest = newest.copy()
            _use(reading, known, taxels.link, newest, path)
            times.append(reading.time)
            values.append(newest)
    except SourceEndedError:
        pass
    finally:
        source.close()
    return np.array(times), np.array(values).reshape(-1, len(taxels))


def _use(reading: Reading, known: Mapping[str, int], link: str | None, newest: FloatArray, path: Path) -> None:
    """Put the values of a reading into ``newest`` (taxels,)."""
    if reading.ids is None and reading.channels is None:
        if len(reading.values) != len(newest):
            found = f"{len(reading.values)} values for {len(newest)} taxels"
            raise LiveError("readings do not fit the taxels", file=path, value=found, remedy="Name the taxels by id")
        newest[:] = reading.values
        return
    labels = reading.ids if reading.ids is not None else reading.channels
    assert labels is not None
    links = reading.links or (None,) * len(labels)
    for label, on, value in zip(labels.tolist(), links, reading.values.tolist(), strict=True):
        name = ".".join(map(str, label)) if isinstance(label, list) else str(label)
        if on in (None, link) and name in known:
            newest[known[name]] = value


def _labels(taxels: TaxelSet) -> Mapping[str, int]:
    """Return the taxel of each id, and of each ``module.channel``, that only one taxel has."""
    labels = [str(number) for number in taxels.stated_ids.tolist()]
    pairs = [(label, row) for row, label in enumerate(labels)]
    if taxels.aliases is not None:
        pairs += [(str(number), row) for number, row in taxels.aliases.tolist()]
    if taxels.modules is not None and taxels.channels is not None:
        numbers = zip(taxels.modules.tolist(), taxels.channels.tolist(), strict=True)
        pairs += [(f"{module}.{channel}", row) for row, (module, channel) in enumerate(numbers)]
    found: dict[str, int] = {}
    twice = {label for label, row in pairs if found.setdefault(label, row) != row}
    return {label: row for label, row in found.items() if label not in twice}
