"""Contact models: errors of the pressures of the user's own skin for known touches."""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import TypeAlias

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.base.rows import bootstrap_interval
from tactile_maps.studies.study.work_precision import ErrorKind, Setting, Stage, Subject, Trial, timed
from tactile_maps.studies.testbeds.reference_touch import (
    DensePoints,
    ReferenceTouch,
    cell_centres,
    pairwise_blur,
    press_ball,
    touch_errors,
)
from tactile_maps.tactile.mechanics.contact_notes import contact_note_text
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE, cutoff_radius
from tactile_maps.tactile.mechanics.receptive_field import quadrature_points
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, ContactModel
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

SHARES = (0.3, 0.1, 0.03, TAIL_SHARE)
"""Shares of a force that receptive fields of the half-space leave out."""
_CONTACT = 0.005
_TOUCHES = 24
_SEED = 0
_DENSE = 2500
_READINGS = 200
_BUDGET = 0.2
_AROUND = 1.2
"""Extent of the dense points, as a multiple of the reach of contact and blur."""
ERRORS = (
    ErrorKind(
        "depth_percent",
        "Pressure at the taxels' depth",
        "% of the force",
        "Force on the wrong taxels as a "
        "share of the total force, compared with the force that passes through the cover to their depth.",
        1e-2,
    ),
    ErrorKind(
        "surface_percent",
        "Pressure at the surface",
        "% of the force",
        "The same compared with the force on the surface of the cover.",
        1e-2,
    ),
    ErrorKind("place_mm", "Centre of pressure", "mm", "Error of the centre of pressure along the skin.", 1e-3),
    ErrorKind("force_percent", "Total force", "%", "Error of the total force (pressure times area).", 1e-12),
)


def settings(subject: Subject) -> list[Setting]:
    """Return every model, and the half-space with increasing receptive fields."""
    others = [Setting("touch", name) for name in CONTACT_MODELS if name != "half-space"]
    return [*others, *(Setting("touch", "half-space", {"share": share}) for share in SHARES)]


def trials(subject: Subject, setting: Setting) -> Iterator[Trial]:
    """Yield the readings of the model for the same touches: mean errors, and the time of a reading [ms]."""
    skin = subject.map.skin
    touches = _touches(skin)
    model = _build_model(skin, setting)
    reads = [partial(model.pressures, [touch.load]) for touch in touches]
    share = setting.values.get("share")
    name = "" if share is None else f"{100 * float(share):g}\u202f% left out"
    note = "; ".join(map(contact_note_text, model.notes))
    yield touch_trial(setting, reads, touches, skin, repeats=_READINGS, budget=_BUDGET, name=name, note=note)


ReadPressures: TypeAlias = Callable[[], FloatArray]
"""Returns the pressures (taxels,) [Pa] of one touch."""


def touch_trial(
    setting: Setting,
    reads: Sequence[ReadPressures],
    touches: Sequence[ReferenceTouch],
    skin: Skin,
    *,
    repeats: int,
    budget: float = math.inf,
    name: str = "",
    note: str = "",
) -> Trial:
    """Return the time of a reading [ms] and the errors of the readings, see ``mean_touch_errors``.

    Args:
        setting: The setting.
        reads: One function for each touch.
        touches: Touches with their true pressures.
        skin: The skin.
        repeats: Number of timed readings, in turn, after a warm-up.
        budget: Time after which no further reading begins [s].
        name: Name of the trial.
        note: Note of the trial.
    """
    columns = _error_columns([read() for read in reads], touches, skin)
    turns = itertools.cycle(reads)
    reading = timed(lambda: next(turns)(), repeats=repeats, budget=budget, warm_up=True)
    found = {key: bootstrap_interval(column, _STATISTICS[key]) for key, column in columns.items()}
    intervals = {key: ends for key, ends in found.items() if ends is not None}
    return Trial(
        setting, name, reading.ms, _means(columns, len(touches)), note, p95_ms=reading.p95_ms, intervals=intervals
    )


def mean_touch_errors(
    readings: Iterable[FloatArray], touches: Sequence[ReferenceTouch], skin: Skin
) -> dict[str, float | None]:
    """Return the mean errors of readings (taxels,) [Pa] of the touches, by key.

    ``place_mm`` is the root mean square over the touches with a reading, or None without any; ``missed_percent`` is the
    share of the other touches.
    """
    return _means(_error_columns(readings, touches, skin), len(touches))


def _error_columns(
    readings: Iterable[FloatArray], touches: Sequence[ReferenceTouch], skin: Skin
) -> dict[str, FloatArray]:
    """Errors by key, of the touches that have one."""
    centres = cell_centres(skin)
    found = [touch_errors(touch, read, skin, centres) for touch, read in zip(touches, readings, strict=True)]
    return {kind.key: np.array([value for each in found if (value := each[kind.key]) is not None]) for kind in ERRORS}


def _means(columns: Mapping[str, FloatArray], touches: int) -> dict[str, float | None]:
    errors = {key: float(_STATISTICS[key](column[None])[0]) if len(column) else None for key, column in columns.items()}
    return errors | {"missed_percent": 100 * ((touches - len(columns["place_mm"])) / touches)}


def _row_means(rows: FloatArray) -> FloatArray:
    return np.asarray(rows.mean(axis=1))


def _row_rms(rows: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(rows**2, axis=1)))


_STATISTICS = {kind.key: _row_rms if kind.key == "place_mm" else _row_means for kind in ERRORS}
"""Statistics of errors (k, touches) as (k,), by key."""


def _build_model(skin: Skin, setting: Setting) -> ContactModel:
    if setting.method == "half-space":
        return HalfSpaceModel(skin, share=float(setting.values["share"]))
    return CONTACT_MODELS[setting.method].build(skin, ElasticLayer(), SensorEffects())


@lru_cache(maxsize=1)
def _touches(skin: Skin) -> tuple[ReferenceTouch, ...]:
    """Touches far from every border, the same for every setting. Cost: 20 ms each."""
    layer = ElasticLayer()
    generator = np.random.default_rng(_SEED)
    span = _AROUND * (_CONTACT + cutoff_radius(layer.depth, TAIL_SHARE))
    every = [
        (number, face) for number, patch in enumerate(skin.patches) for face in _inner_faces(patch.surface).tolist()
    ]
    touches = []
    for number, face in generator.choice(every, _TOUCHES):
        patch = skin.patches[number]
        at = patch.surface.point(face, generator.dirichlet(np.ones(3)))
        dense = dense_around(skin, patch.link, at, span)
        normal = patch.surface.face_normals[face]
        blur = pairwise_blur(dense, layer.depth)
        touches.append(press_ball(dense, at, normal, _CONTACT, taxels=len(skin), blur=blur, layer=layer))
    return tuple(touches)


def _inner_faces(surface: Mesh) -> IntArray:
    """The third of the triangles of a surface that is farthest from its border; all triangles without a border."""
    border = surface.vertices[np.unique(surface.connectivity.boundary_edges)]
    if not len(border):
        return np.arange(len(surface.faces))
    away = cKDTree(border).query(surface.vertices[surface.faces].mean(axis=1))[0]
    return np.flatnonzero(away >= np.quantile(away, 2 / 3))


def dense_around(skin: Skin, link: str, at: FloatArray, radius: float) -> DensePoints:
    """Return about ``_DENSE`` points on the skin of a link within ``radius`` [m] of ``at`` (3,), link frame.

    All triangles are divided equally; a point belongs to the taxel with the nearest quadrature point.
    """
    everything = quadrature_points(skin)
    here = np.flatnonzero([skin.patches[patch].link == link for patch in skin.patch_of[everything.taxel]])
    corners, normals, areas = _triangles(skin, link, at, radius)
    weights = _subdivision_centres(max(round(np.sqrt(_DENSE / max(len(corners), 1))), 1))
    points = np.einsum("wc,mcd->mwd", weights, corners).reshape(-1, 3)
    owner: IntArray = everything.taxel[here[cKDTree(everything.positions[here]).query(points)[1]]]
    each = len(weights)
    parts = np.repeat(areas / each, each)
    return DensePoints(link, points, np.repeat(normals, each, axis=0), parts, owner, parts)


def _triangles(skin: Skin, link: str, at: FloatArray, radius: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Corners (m, 3, 3), normals and areas of the triangles of a link whose centres are near."""
    parts = []
    for patch in skin.patches:
        if patch.link == link:
            surface = patch.surface
            corners = surface.vertices[surface.faces]
            near = np.linalg.norm(corners.mean(axis=1) - at, axis=1) < radius
            parts.append((corners[near], surface.face_normals[near], surface.face_areas[near]))
    corners, normals, areas = (np.concatenate(part) for part in zip(*parts, strict=True))
    return corners, normals, areas


def _subdivision_centres(side: int) -> FloatArray:
    """(side², 3) barycentric centres of the equal triangles of a triangle with ``side`` parts on each side."""
    up = [(3 * i + 1, 3 * j + 1) for i in range(side) for j in range(side - i)]
    down = [(3 * i + 2, 3 * j + 2) for i in range(side - 1) for j in range(side - 1 - i)]
    first = np.array(up + down) / (3 * side)
    return np.column_stack([first, 1 - first.sum(axis=1)])


def fingerprint(subject: Subject) -> str:
    """Return a digest of the places of the taxels and their quadrature points."""
    digest = hashlib.blake2b(digest_size=8)
    for patch in subject.map.skin.patches:
        digest.update(patch.taxels.positions.tobytes())
        digest.update(patch.taxels.quadrature.positions.tobytes())
    return digest.hexdigest()


def seconds(subject: Subject) -> float:
    """Return the approximate duration of all trials [s]."""
    return 4 + 2e-3 * len(subject.map.skin)


STAGE = Stage(
    "touch",
    "Touch",
    "Which contact model is most accurate, and how long does a reading take?",
    tuple(CONTACT_MODELS),
    ERRORS,
    settings,
    trials,
    fingerprint,
    seconds,
    "Upright lines are 95\u202f% intervals over the touched places.",
)
