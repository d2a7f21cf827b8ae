"""Frames as bytes, exact to the last bit.

A message is little-endian, without padding:

    int64  tick                     float64 time [s]
    int32  joints, taxels, objects, pokes, regions, region taxels in all, bytes of words
    float64  posture, velocity (joints each), pressures [Pa] (taxels), command posture, stiffness, damping, torque
    float64  per object (16): its pose in the world as a homogeneous matrix, row by row
    float64  per poke (14): id, patch, face, 3 weights, force [N], point [m] (3), normal (3), radius [m]
    float64  per region (34): id, patch, face, 3 weights, force [N], area [m²], peak [Pa], map point [m] (2),
             point in the link [m] (3), normal in the link (3), number of taxels, 1 where a seam tears it (else 0),
             mean [Pa], half-axes in the link [m] (2 x 3) and on the map [m] (2 x 2), standard uncertainty of place [m]
             and force [N], id of the partner in self-touch (0: none), id of the region it split from at this tick (0:
             none)
    int32    taxel numbers of all regions, one after the other
    UTF-8 JSON  {"why_limited": [...], "notes": [...], "ms": {stage: milliseconds}, "merged": {id: [ids that became
             part of it at this tick]}, "task": {field: value of TaskReport}; null under a controller without a task,
             "estimates": {id: {field: value of ForceEstimate}}; where there are none, nothing}

Floats in JSON are written so that they read back equal.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from app.contacts.force_estimation.estimate import ForceEstimate
from app.contacts.regions import ContactRegion
from app.control.command import JointCommand, TaskReport
from app.core.errors import RecordingError
from app.core.timing import Timings
from app.geometry.mesh import SurfacePoint
from app.session.frame import Frame
from app.skin.skin import Skin
from app.tactile.poke import PokeState

_ESTIMATE_FIELDS = tuple(field.name for field in fields(ForceEstimate))


def estimates_to_json(estimates: Mapping[int, ForceEstimate]) -> dict[str, Any]:
    """Every field by its name, by region. Cost: 5 µs each."""
    return {
        str(region): {name: _json_value(getattr(one, name)) for name in _ESTIMATE_FIELDS}
        for region, one in estimates.items()
    }


def estimates_from_json(raw: Mapping[str, Any]) -> dict[int, ForceEstimate]:
    """The estimates of ``estimates_to_json``, equal to the last bit.

    Raises:
        ValueError: A number is none, or a field is missing (KeyError) or of another kind (TypeError).
    """
    return {int(region): _estimate(one) for region, one in raw.items()}


def _json_value(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    return [value.patch, value.face, *value.weights] if isinstance(value, SurfacePoint) else value


def _estimate(raw: Mapping[str, Any]) -> ForceEstimate:
    at, whole = raw["at"], ("effective_rank", "unknowns")
    known: dict[str, Any] = {
        "at": None if at is None else SurfacePoint(int(at[0]), int(at[1]), (float(at[2]), float(at[3]), float(at[4]))),
        "taxels": np.array(raw["taxels"], dtype=np.int64),
        "forces": np.array(raw["forces"], dtype=np.float64),
        "refused": str(raw["refused"]),
    }
    known |= {name: int(raw[name]) for name in whole}
    known |= {name: float(raw[name]) for name in _ESTIMATE_FIELDS if name not in known}
    return ForceEstimate(**known)


_HEAD = struct.Struct("<qd7i")
_OBJECT, _POKE, _REGION = 16, 14, 34
FRAME_SCHEMA = json.dumps({"title": "tactile_maps.Frame", "description": __doc__})


def encode_frame(frame: Frame) -> bytes:
    """One frame as a message."""
    merged = {region.id: region.merged for region in frame.regions if region.merged}
    text: dict[str, Any] = {
        "why_limited": frame.why_limited,
        "notes": frame.notes,
        "ms": frame.timings.ms,
        "merged": merged,
        "task": None if frame.task is None else asdict(frame.task),
    }
    if frame.estimates:
        text["estimates"] = estimates_to_json(frame.estimates)
    words = json.dumps(text).encode()
    taxels = [region.taxels for region in frame.regions]
    head = _HEAD.pack(
        frame.tick,
        frame.time,
        len(frame.posture),
        len(frame.pressures),
        len(frame.objects),
        len(frame.pokes),
        len(frame.regions),
        sum(map(len, taxels)),
        len(words),
    )
    command = frame.command
    numbers: list[Any] = [
        frame.posture,
        frame.velocity,
        frame.pressures,
        command.posture,
        command.stiffness,
        command.damping,
        command.torque,
        frame.objects.ravel(),
    ]
    numbers += [[p.id, *_place_row(p.at), p.force, *p.point, *p.normal, p.radius] for p in frame.pokes]
    numbers += [_region_row(region) for region in frame.regions]
    body = np.concatenate([np.asarray(part, dtype="<f8") for part in numbers]).astype("<f8").tobytes()
    return head + body + np.concatenate([*taxels, []]).astype("<i4").tobytes() + words


def _region_row(r: ContactRegion) -> list[float]:
    row = [r.id, *_place_row(r.at), r.force, r.area, r.peak, *r.map_point, *r.point, *r.normal, len(r.taxels), r.torn]
    return [*row, r.mean, *r.axes.flat, *r.map_axes.flat, r.place_error, r.force_error, r.partner, r.split_from]


def _place_row(at: SurfacePoint) -> tuple[float, ...]:
    return (at.patch, at.face, *at.weights)


def decode_frame(data: bytes, skin: Skin) -> Frame:
    """The frame of a message.

    Raises:
        RecordingError: The message is not a frame of this skin.
    """
    try:
        return _decode_frame(data, skin)
    except (struct.error, ValueError, IndexError, KeyError, TypeError) as error:
        raise RecordingError("a frame of the recording is damaged", value=error) from error


def _decode_frame(data: bytes, skin: Skin) -> Frame:
    tick, time, joints, taxels, objects, pokes, regions, members, words = _HEAD.unpack_from(data)
    before = 6 * joints + taxels + _OBJECT * objects + _POKE * pokes
    room = len(data) - _HEAD.size - 4 * members - words - 8 * before
    sizes = (joints, taxels, objects, pokes, regions, members, words)
    if min(sizes) < 0 or (taxels, room) != (len(skin), 8 * _REGION * regions):
        raise ValueError("its sizes do not add up")
    count = before + _REGION * regions
    numbers = np.frombuffer(data, "<f8", count, _HEAD.size)
    named = np.frombuffer(data, "<i4", members, _HEAD.size + 8 * count).astype(np.int64)
    text = json.loads(data[len(data) - words :])
    parts = np.split(numbers, np.cumsum([joints, joints, taxels, *[joints] * 4, _OBJECT * objects, _POKE * pokes]))
    rows, merged = parts[9].reshape(regions, _REGION), text["merged"]
    groups = np.split(named, np.cumsum(rows[:, 17].astype(int))[:-1]) if regions else []
    return Frame(
        tick,
        time,
        parts[0],
        parts[1],
        parts[2],
        tuple(_region(row, group, skin, merged) for row, group in zip(rows, groups, strict=True)),
        tuple(_poke(row) for row in parts[8].reshape(pokes, _POKE)),
        JointCommand(*parts[3:7]),
        tuple(map(str, text["why_limited"])),
        Timings({str(stage): float(ms) for stage, ms in text["ms"].items()}),
        parts[7].reshape(objects, 4, 4),
        tuple(map(str, text["notes"])),
        task=_task(text["task"]),
        estimates=estimates_from_json(text.get("estimates", {})),
    )


def _task(raw: dict[str, Any] | None) -> TaskReport | None:
    if raw is None:
        return None
    target, laid_at = raw["target"], raw["laid_at"]
    place = None if target is None else _place_from_row([target["patch"], target["face"], *target["weights"]])
    return TaskReport(**{**raw, "target": place, "laid_at": None if laid_at is None else (laid_at[0], laid_at[1])})


def _poke(row: Any) -> PokeState:
    return PokeState(int(row[0]), _place_from_row(row[1:6]), float(row[6]), row[7:10], row[10:13], float(row[13]))


def _region(row: Any, taxels: Any, skin: Skin, merged: dict[str, list[int]]) -> ContactRegion:
    at, id_ = _place_from_row(row[1:6]), int(row[0])
    return ContactRegion(
        id_,
        taxels,
        float(row[6]),
        float(row[7]),
        float(row[8]),
        row[9:11],
        at,
        skin.link(at),
        row[11:14],
        row[14:17],
        bool(row[18]),
        merged=tuple(map(int, merged.get(str(id_), ()))),
        mean=float(row[19]),
        axes=row[20:26].reshape(2, 3),
        map_axes=row[26:30].reshape(2, 2),
        place_error=float(row[30]),
        force_error=float(row[31]),
        partner=int(row[32]),
        split_from=int(row[33]),
    )


def _place_from_row(row: Any) -> SurfacePoint:
    return SurfacePoint(int(row[0]), int(row[1]), (float(row[2]), float(row[3]), float(row[4])))
