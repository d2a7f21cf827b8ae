"""Bit-exact encoding of frames as bytes, decoded without trusting the data.

Numbers that every frame has are binary, as defined by the constants here; the rest, ``FrameText``, is JSON by
``tactile_maps.core.codec``.
A message is one field of bytes in Protobuf, see ``frame_schema``. The bytes are little-endian, without padding:
``HEADER``, ``ARRAYS``, a ``POKE`` for each finger, a ``REGION`` for each contact region, the regions' taxel numbers one
region after the other (int32), the JSON, and for a sheared skin the tractions along both axes of each taxel (float64),
followed by the values as sent if it is a real one.
``FRAME_LAYOUT`` describes this in the file.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from types import MappingProxyType
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from tactile_maps.contacts.detection.contact_shear import ContactShear
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.contacts.force_estimation.estimate import ForceEstimate
from tactile_maps.control.motion.command import JointCommand, TaskReport
from tactile_maps.control.motion.limits import Limit
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.codec import LATER, AnyFloat, dump_json, json_schema, load_json
from tactile_maps.core.errors import RecordingError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.core.timing import Timings
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.recording.encoding.frame_schema import PREFIX_BYTES, descriptor, has_prefix, prefix
from tactile_maps.session.bundle import DAMAGED
from tactile_maps.session.frame import Frame, MeasuredValues
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.contact_notes import ContactNote
from tactile_maps.tactile.poke import PokeState

HEADER: Mapping[str, str] = MappingProxyType(
    {
        "tick": "q",
        "time": "d",
        "joints": "i",
        "taxels": "i",
        "objects": "i",
        "raw": "i",
        "pokes": "i",
        "regions": "i",
        "region taxels": "i",
        "text bytes": "i",
    }
)
"""Name and type (as in ``struct``) of each number: tick, time [s], and the sizes of what follows."""
ARRAYS: Mapping[str, str] = MappingProxyType(
    {
        "posture": "joints",
        "velocity": "joints",
        "pressures": "taxels",
        "command.posture": "joints",
        "command.stiffness": "joints",
        "command.damping": "joints",
        "command.torque": "joints",
        "objects": "objects",
        "measured.raw": "raw",
    }
)
"""Number of float64 by attribute of the frame; ``objects`` has 16 for each pose, row by row. SI units; ``measured.raw``
as sent, empty where the skin is simulated.
"""
_PLACE: list[tuple[Any, ...]] = [("at.patch", "<i4"), ("at.face", "<i4"), ("at.weights", "<f8", (3,))]
POKE = np.dtype(
    [
        ("id", "<i8"),
        *_PLACE,
        ("force", "<f8"),
        ("world_position", "<f8", (3,)),
        ("world_normal", "<f8", (3,)),
        ("radius", "<f8"),
    ]
)
"""Attributes of a ``PokeState``."""
REGION = np.dtype(
    [
        ("id", "<i8"),
        *_PLACE,
        ("force", "<f8"),
        ("area", "<f8"),
        ("peak", "<f8"),
        ("mean", "<f8"),
        ("map_point", "<f8", (2,)),
        ("link_position", "<f8", (3,)),
        ("link_normal", "<f8", (3,)),
        ("link_axes", "<f8", (2, 3)),
        ("map_axes", "<f8", (2, 2)),
        ("place_error", "<f8"),
        ("force_error", "<f8"),
        ("partner", "<i8"),
        ("split_from", "<i8"),
        ("torn", "u1"),
        ("taxels.size", "<i4"),
    ]
)
"""Attributes of a ``ContactRegion``; its link follows from its location, and merged ids are in the text. Id 0 means
none: regions count from 1.
"""
_OPTIONAL_IDS = ("partner", "split_from")


@dataclass(frozen=True)
class MeasuredText:
    """``MeasuredValues`` without the values."""

    unit: Literal["counts", "Pa", "kPa"]
    sent: float | None
    sequence: int | None
    units: ReadingUnits


@dataclass(frozen=True)
class FrameText:
    """Words and collections of variable size in a frame, as JSON.

    Attributes:
        why_limited: See ``Frame``.
        notes: See ``Frame``.
        ms: Milliseconds by stage.
        merged: Ids that became part of a region at this tick, by region; only for regions with any.
        task: See ``Frame``.
        estimates: See ``Frame``.
        measured: ``MeasuredValues`` without the values, which are among the arrays; None where the skin is simulated.
        touched: Number of touched taxels by region; recordings of earlier versions do not store it.
        parts: Parts of the force's uncertainty [N] by region and name; only for regions with any.
        limits: The same parts for the 95 % interval [N].
        shears: Shear by region; only for regions with any.
    """

    why_limited: tuple[Limit, ...]
    notes: tuple[ContactNote, ...]
    ms: Mapping[str, float]
    merged: Mapping[int, tuple[int, ...]]
    task: TaskReport | None
    estimates: Mapping[int, ForceEstimate]
    measured: MeasuredText | None
    touched: Mapping[int, int] = field(default_factory=dict, metadata=LATER)
    parts: Mapping[int, Mapping[str, AnyFloat]] = field(default_factory=dict, metadata=LATER)
    limits: Mapping[int, Mapping[str, AnyFloat]] = field(default_factory=dict, metadata=LATER)
    shears: Mapping[int, ContactShear] = field(default_factory=dict, metadata=LATER)


def _columns(record: np.dtype[Any]) -> list[str]:
    return [f"{name}: {record[name].base.name}{list(record[name].shape) or ''}" for name in record.names or ()]


FRAME_LAYOUT = json.dumps(
    {
        "type": "object",
        "title": "tactile_maps.Frame",
        "description": "Little-endian without padding: header, arrays of float64, pokes, regions, int32 taxel numbers "
        "of all regions, text as JSON in UTF-8, then nothing or two float64 of shear [Pa] for each taxel, and then "
        "nothing or two float64 of shear as sent for each taxel, NaN where none arrived",
        "header": dict(HEADER),
        "arrays": dict(ARRAYS),
        "poke": _columns(POKE),
        "region": _columns(REGION),
        "text": json_schema(FrameText),
    }
)

FRAME_SCHEMA = descriptor("tactile_maps", "Frame", FRAME_LAYOUT)
"""Protobuf description of the message, with the layout as its comment."""
_HEADER = struct.Struct("<" + "".join(HEADER.values()))
_ARRAYS_AT = PREFIX_BYTES + _HEADER.size
_POSE = 16
_SHEAR = 16
"""Bytes of shear for each taxel."""
_FINITE = ("force", "area", "peak", "mean", "map_point", "link_position", "link_normal", "link_axes", "map_axes")
"""Finite attributes of a region; its error bars may be infinite."""
_COMMAND = ("posture", "stiffness", "damping", "torque")
_NO_RAW = np.zeros(0)
_arrays_of = attrgetter(*[name for name in ARRAYS if name != "measured.raw"])
_poke_row = attrgetter(*POKE.names or ())
_region_row = attrgetter(*REGION.names or ())


def encode_frame(frame: Frame) -> bytes:
    """Return a frame as a message. Cost: 30 µs, 10 µs per region and 10 µs per estimate."""
    regions = frame.regions
    text = FrameText(
        frame.why_limited,
        frame.notes,
        frame.timings.ms,
        {region.id: region.merged for region in regions if region.merged},
        frame.task,
        frame.estimates,
        _measured_text(frame.measured),
        {region.id: region.touched for region in regions if region.touched is not None},
        {region.id: region.force_parts for region in regions if region.force_parts},
        {region.id: region.force_limits for region in regions if region.force_limits},
        {region.id: region.shear for region in regions if region.shear},
    )
    raw = _NO_RAW if frame.measured is None else frame.measured.raw
    words = dump_json(text)
    taxels = [region.taxels.astype("<i4").tobytes() for region in regions]
    head = _HEADER.pack(
        frame.tick,
        frame.time,
        len(frame.posture),
        len(frame.pressures),
        len(frame.objects),
        len(raw),
        len(frame.pokes),
        len(regions),
        sum(map(len, taxels)) // 4,
        len(words),
    )
    arrays = [np.asarray(values, dtype="<f8").tobytes() for values in (*_arrays_of(frame), raw)]
    pokes = np.array([_poke_row(poke) for poke in frame.pokes], dtype=POKE).tobytes() if frame.pokes else b""
    rows = [tuple(0 if value is None else value for value in _region_row(region)) for region in regions]
    records = np.array(rows, dtype=REGION).tobytes() if rows else b""
    shear = b"" if frame.shear is None else np.asarray(frame.shear, dtype="<f8").tobytes()
    if frame.measured is not None and frame.measured.raw_shear is not None:
        shear += np.asarray(frame.measured.raw_shear, dtype="<f8").tobytes()
    data = b"".join([head, *arrays, pokes, records, *taxels, words, shear])
    return prefix(len(data)) + data


def _measured_text(measured: MeasuredValues | None) -> MeasuredText | None:
    if measured is None:
        return None
    unit = cast("Literal['counts', 'Pa', 'kPa']", measured.unit)
    return MeasuredText(unit, measured.sent, measured.sequence, measured.units)


def decode_frame(data: bytes, prepared: PreparedScene, *, file: str | None = None) -> Frame:
    """Return the frame of a message.

    Args:
        data: The untrusted message.
        prepared: The recorded scene.
        file: Its file, for errors.

    Raises:
        RecordingError: The message is damaged or of another scene; the place names the part.
    """
    return _FrameReader(data, prepared, file).frame()


def tick_of(data: bytes, *, file: str | None = None) -> int:
    """Return the tick of a frame's message without decoding the rest.

    Raises:
        RecordingError: The message has no valid tick.
    """
    if len(data) < _ARRAYS_AT or (tick := int(_HEADER.unpack_from(data, PREFIX_BYTES)[0])) < 0:
        problem = "the frame has no tick"
        raise RecordingError(problem, file=file, place="/frame: header", value=f"{len(data)} bytes", remedy=DAMAGED)
    return tick


class FrameNumbers(NamedTuple):
    """Numbers of a frame that are plotted as curves.

    Attributes:
        tick: Tick of the frame.
        force: Sum of all contact forces [N]; of a real skin in its units.
        peak: Highest reading [Pa].
        speed: Speed of the fastest joint [rad/s], or slide [m/s].
        error: Distance to the target on the map [m]; NaN without a task that has one.
    """

    tick: int
    force: float
    peak: float
    speed: float
    error: float


class FrameArrays(NamedTuple):
    """Arrays of a frame's message, as views, and its undecoded text.

    Attributes:
        tick: Tick of the frame.
        posture: (joints,) [rad], [m] for slides.
        velocity: (joints,) [rad/s], [m/s] for slides.
        pressures: (taxels,) [Pa].
        patches: (k,) patches of the contacts.
        forces: (k,) forces of the contacts [N].
        text: ``FrameText`` as JSON.
    """

    tick: int
    posture: FloatArray
    velocity: FloatArray
    pressures: FloatArray
    patches: IntArray
    forces: FloatArray
    text: bytes


def frame_arrays(data: bytes) -> FrameArrays | None:
    """Return the arrays of a frame's message without decoding the frame; None if it is invalid. Cost: 8 µs."""
    if len(data) < _ARRAYS_AT or not has_prefix(data):
        return None
    tick, _time, *counts = _HEADER.unpack_from(data, PREFIX_BYTES)
    sizes = _Sizes(*counts)
    floats = 6 * sizes.joints + sizes.taxels + _POSE * sizes.objects + sizes.raw
    before = _ARRAYS_AT + 8 * floats + sizes.pokes * POKE.itemsize
    text = before + sizes.regions * REGION.itemsize + 4 * sizes.members
    if min(sizes) < 0 or len(data) - text - sizes.text not in _shear_bytes(sizes):
        return None
    joints = sizes.joints
    values = np.frombuffer(data, "<f8", 2 * joints + sizes.taxels, _ARRAYS_AT)
    regions = np.frombuffer(data, REGION, sizes.regions, before)
    return FrameArrays(
        tick,
        values[:joints],
        values[joints : 2 * joints],
        values[2 * joints :],
        regions["at.patch"],
        regions["force"],
        data[text : text + sizes.text],
    )


def frame_numbers(frame: FrameArrays) -> FrameNumbers:
    """Return the numbers of a frame that are plotted as curves."""
    peak = np.fmax.reduce(frame.pressures, initial=0.0)
    speed = np.abs(frame.velocity).max(initial=0.0)
    return FrameNumbers(frame.tick, float(frame.forces.sum()), float(peak), float(speed), _map_error(frame.text))


def _map_error(text: bytes) -> float:
    if b'"task":null' in text:
        return float("nan")
    try:
        error = json.loads(text)["task"]["error"]
    except (ValueError, LookupError, TypeError):
        return float("nan")
    return float(error) if isinstance(error, int | float) else float("nan")


def frame_shear(frame: FrameArrays) -> tuple[float, float]:
    """Return the sum of the contacts' forces along the skin [N] and their highest friction in use; NaN if unknown."""
    if b'"shears":' not in frame.text:
        return float("nan"), float("nan")
    try:
        shears = json.loads(frame.text)["shears"].values()
        return sum(math.hypot(*one["force"]) for one in shears), max((float(one["usage"]) for one in shears), default=0)
    except (ValueError, LookupError, TypeError, AttributeError):
        return float("nan"), float("nan")


class _Sizes(NamedTuple):
    """Sizes in the order of ``HEADER``."""

    joints: int
    taxels: int
    objects: int
    raw: int
    pokes: int
    regions: int
    members: int
    text: int


def _shear_bytes(sizes: _Sizes) -> tuple[int, int, int]:
    """Return the possible numbers of bytes after the text: none, shear, and shear as sent after it."""
    return 0, _SHEAR * sizes.taxels, 2 * _SHEAR * sizes.taxels


class _FrameReader:
    """Decodes a message from start to end; invalid parts raise an error that names them."""

    def __init__(self, data: bytes, prepared: PreparedScene, file: str | None) -> None:
        self._data = data
        self._skin = prepared.skin
        self._file = file
        if len(data) < _ARRAYS_AT:
            raise self._refusal("the frame is too short", "header", f"{len(data)} bytes")
        if not has_prefix(data):
            raise self._refusal("the frame is not one field of bytes", "prefix", f"{len(data)} bytes")
        self._tick, self._time, *counts = _HEADER.unpack_from(data, PREFIX_BYTES)
        self._sizes = _Sizes(*counts)
        self._at = _ARRAYS_AT
        if self._tick < 0 or not np.isfinite(self._time):
            raise self._refusal("invalid time", "header", f"tick {self._tick}, {self._time} s")
        self._check_sizes(prepared)

    def _check_sizes(self, prepared: PreparedScene) -> None:
        sizes = self._sizes
        if min(sizes) < 0:
            raise self._refusal("a size is negative", "header", tuple(sizes))
        known = (len(prepared.robot.joints), len(prepared.skin), len(prepared.objects))
        if (sizes.joints, sizes.taxels, sizes.objects) != known:
            raise self._refusal("the frame is of another robot, skin or scene", "header", tuple(sizes))
        if sizes.raw not in (0, sizes.taxels):
            raise self._refusal("the number of raw values differs from the number of taxels", "header", sizes.raw)
        floats = sum(self._length(of) for of in ARRAYS.values())
        records = sizes.pokes * POKE.itemsize + sizes.regions * REGION.itemsize
        rest = len(self._data) - (self._at + 8 * floats + records + 4 * sizes.members + sizes.text)
        if rest not in _shear_bytes(sizes):
            raise self._refusal("the sizes do not add up", "header", f"{len(self._data)} bytes")

    def frame(self) -> Frame:
        """Return the frame; called once."""
        arrays = {name: self._take(np.dtype("<f8"), self._length(of)) for name, of in ARRAYS.items()}
        for name in ("posture", "velocity", "objects"):
            self._check_finite(arrays[name], name)
        pokes = self._take(POKE, self._sizes.pokes)
        regions = self._take(REGION, self._sizes.regions)
        members = self._take(np.dtype("<i4"), self._sizes.members)
        text = load_json(
            FrameText,
            self._data[self._at : self._at + self._sizes.text],
            error=RecordingError,
            place="/frame",
            file=self._file,
            remedy=DAMAGED,
        )
        self._at += self._sizes.text
        rest = self._take(np.dtype("<f8"), (len(self._data) - self._at) // 8).reshape(-1, 2)
        shear = rest[: self._sizes.taxels]
        self._check_finite(shear, "shear")
        if text.task is not None and text.task.target is not None:
            self._check_place(text.task.target, "task.target")
        for number, estimate in text.estimates.items():
            if estimate.at is not None:
                self._check_place(estimate.at, f"estimates.{number}.at")
        return Frame(
            tick=self._tick,
            time=self._time,
            posture=arrays["posture"],
            velocity=arrays["velocity"],
            pressures=arrays["pressures"],
            regions=self._regions(regions, members, text),
            pokes=self._pokes(pokes),
            command=JointCommand(*(arrays[f"command.{name}"] for name in _COMMAND)),
            why_limited=text.why_limited,
            timings=Timings(dict(text.ms)),
            objects=arrays["objects"].reshape(-1, 4, 4),
            notes=text.notes,
            task=text.task,
            estimates=text.estimates,
            measured=self._measured(text.measured, arrays["measured.raw"], rest[self._sizes.taxels :]),
            shear=shear if len(shear) else None,
        )

    def _length(self, of: str) -> int:
        return getattr(self._sizes, of) * (_POSE if of == "objects" else 1)

    def _take(self, dtype: np.dtype[Any], count: int) -> Any:
        """Return the next ``count`` values."""
        values = np.frombuffer(self._data, dtype, count, self._at)
        self._at += values.nbytes
        return values

    def _pokes(self, rows: Any) -> tuple[PokeState, ...]:
        if not len(rows):
            return ()
        for name in ("force", "world_position", "world_normal", "radius"):
            self._check_finite(rows[name], f"pokes.{name}")
        places = self._places(rows, "pokes")
        return tuple(PokeState(at=at, **values) for at, values in zip(places, _fields(rows), strict=True))

    def _regions(self, rows: Any, members: IntArray, text: FrameText) -> tuple[ContactRegion, ...]:
        counts = rows["taxels.size"]
        if (counts < 0).any() or int(counts.sum(dtype=np.int64)) != len(members):
            raise self._refusal("the sizes of the regions do not add up", "regions.taxels.size", counts.tolist())
        if not len(rows):
            return ()
        if members.size and not 0 <= members.min() <= members.max() < len(self._skin):
            raise self._refusal("unknown taxel", "regions.taxels", f"{members.min()} to {members.max()}")
        if (rows["torn"] > 1).any():
            raise self._refusal("this must be 0 or 1", "regions.torn", rows["torn"].tolist())
        for name in _FINITE:
            self._check_finite(rows[name], f"regions.{name}")
        for number, count in zip(rows["id"].tolist(), counts.tolist(), strict=True):
            touched = text.touched.get(number)
            if touched is not None and not 0 < touched <= count:
                raise self._refusal(f"this must be 1 to {count}", f"touched.{number}", touched)
        places = self._places(rows, "regions")
        groups = np.split(members, np.cumsum(counts)[:-1])
        return tuple(
            ContactRegion(
                **values | {"torn": bool(values["torn"])} | {name: values[name] or None for name in _OPTIONAL_IDS},
                at=at,
                taxels=taxels,
                link=self._skin.link(at),
                merged=text.merged.get(values["id"], ()),
                touched=text.touched.get(values["id"]),
                force_parts=text.parts.get(values["id"], {}),
                force_limits=text.limits.get(values["id"], {}),
                shear=text.shears.get(values["id"]),
            )
            for values, at, taxels in zip(_fields(rows), places, groups, strict=True)
        )

    def _places(self, rows: Any, part: str) -> list[SurfacePoint]:
        columns = (rows[name].tolist() for name in ("at.patch", "at.face", "at.weights"))
        places = [SurfacePoint(patch, face, (a, b, c)) for patch, face, (a, b, c) in zip(*columns, strict=True)]
        for number, at in enumerate(places):
            self._check_place(at, f"{part}[{number}].at")
        return places

    def _check_place(self, at: SurfacePoint, part: str) -> None:
        check_place(at, self._skin, place=f"/frame: {part}", file=self._file)

    def _measured(self, text: MeasuredText | None, raw: FloatArray, shear: FloatArray) -> MeasuredValues | None:
        if text is None:
            if len(raw) or len(shear):
                raise self._refusal("raw values have no unit", "measured", None)
            return None
        if len(raw) != self._sizes.taxels or np.isinf(raw).any():
            problem = "the taxels need one raw value each, NaN or finite"
            raise self._refusal(problem, "measured.raw", len(raw))
        if np.isinf(shear).any():
            raise self._refusal("this must be finite or NaN", "measured.raw_shear", len(shear))
        return MeasuredValues(raw, text.unit, text.sent, text.sequence, text.units, shear if len(shear) else None)

    def _check_finite(self, values: FloatArray, name: str) -> None:
        if not np.isfinite(values).all():
            raise self._refusal("this must be a finite number", name, values[~np.isfinite(values)][0])

    def _refusal(self, problem: str, part: str, value: object) -> RecordingError:
        return RecordingError(problem, file=self._file, place=f"/frame: {part}", value=value, remedy=DAMAGED)


def _fields(rows: Any) -> list[dict[str, Any]]:
    """Return the values of each row by name, without locations and sizes."""
    names = [name for name in rows.dtype.names if "." not in name]
    columns = [rows[name] if rows[name].ndim > 1 else rows[name].tolist() for name in names]
    return [dict(zip(names, values, strict=True)) for values in zip(*columns, strict=True)]


def check_place(at: SurfacePoint, skin: Skin, *, place: str, file: str | None = None) -> None:
    """Check that a location is on the skin.

    Args:
        at: Location, read from a recording.
        skin: Skin of the recorded scene.
        place: Its place in the message, for the error.
        file: The recording, for the error.

    Raises:
        RecordingError: The patch, face or weights are invalid.
    """
    known = 0 <= at.patch < len(skin.patches) and 0 <= at.face < len(skin.patches[at.patch].surface.faces)
    # NaN compares false
    if not (known and min(at.weights) >= -1e-6 and abs(sum(at.weights) - 1) < 1e-6):
        raise RecordingError("the location is not on the skin", file=file, place=place, value=at, remedy=DAMAGED)
