"""Cost of accuracy in shear, by contact model, number of taxels and stiffness of the cover.

A ball is pressed into a flat skin and dragged; tractions of each contact model are compared with a Winkler bed with
Coulomb friction that is sampled at 200,000 points.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain

import numpy as np
from scipy.optimize import brentq

from tactile_maps.core.arrays import FloatArray
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.base.figures import Figure
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.study.work_precision import ErrorKind, work_precision_figures
from tactile_maps.studies.sweeps.touch_cost import TITLES, bare_step_ms
from tactile_maps.studies.testbeds.reference_bodies import SIDE
from tactile_maps.studies.testbeds.reference_touch import ReferenceSkin, flat_skin
from tactile_maps.tactile.mechanics.coulomb_bed import STUCK
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.mechanics.receptive_field import cell_field
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, WITH_SHEAR, ContactModel
from tactile_maps.tactile.models.point import PointModel
from tactile_maps.tactile.models.shear import ShearModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

MODULI_KPA = (25, 100, 400, 1600)
"""Young's moduli of the cover: contact radii of 14, 10, 7 and 5 mm."""
FORCE = 5.0
"""Normal force of the ball [N], nearly."""
RADIUS = 0.05
"""Radius of the ball [m]."""
FRICTION = 0.5
LOADING = (0.2, 0.5, 0.8, 0.95)
"""Tangential force while the ball is dragged, as shares of the friction limit."""
UNLOADING = (0.5, 0.0, -0.5)
"""The same while it is let go and dragged back, after the last of ``LOADING``."""
ERRORS = (
    ErrorKind(
        "traction_percent",
        "Tractions",
        "% of the friction limit",
        "Tangential force on the wrong taxels as a share of friction times normal force, mean over the states.",
        1e-2,
    ),
    ErrorKind(
        "stuck_percent",
        "Stuck share",
        "percentage points",
        "Error of the share of the friction limit on the part of the contact that sticks, mean over the states.",
        1e-2,
    ),
    ErrorKind(
        "total_percent",
        "Total tangential force",
        "% of the friction limit",
        "Error of the sum of traction times area, mean over the states.",
        1e-13,
    ),
)
_ASIDE = 0.01
"""Maximum distance of the touches from the middle of the skin along each axis [m]."""


@dataclass(frozen=True, eq=False)
class DraggedBall:
    """A ball dragged along a flat skin, with its true shear in each state of ``LOADING`` and ``UNLOADING``.

    Attributes:
        loads: Load in each state.
        forces: (states, taxels) tangential force on each cell along the drag [N].
        stuck: Share of the friction limit on points below ``STUCK`` of theirs, in each state.
        limit: Friction times normal force [N].
    """

    loads: tuple[Load, ...]
    forces: FloatArray
    stuck: FloatArray
    limit: float


def drag_ball(reference: ReferenceSkin, layer: ElasticLayer, across: float, up: float) -> DraggedBall:
    """Drag a ball along x at a place of a flat skin: a Winkler bed with Coulomb friction at 200,000 points.

    All points of a bed move alike. On a first drag by s the traction is min(mu p, k s); when the drag is reversed by s
    it falls by min(2 mu p, k s), since a slider that has slid forward must be unloaded before it slides back (Masing).

    Args:
        reference: The skin.
        layer: Its cover.
        across: Distance of the ball from the middle along x [m].
        up: The same along y [m].
    """
    at, normal = reference.place(across, up)
    depth = _depth(layer)
    dense = reference.dense
    squares = ((dense.positions - at)[:, :2] ** 2).sum(axis=1)
    sunk = np.sqrt(np.maximum(RADIUS**2 - squares, 0.0)) - (RADIUS - depth)
    limits = FRICTION * layer.foundation * np.maximum(sunk, 0.0)
    limit = float(limits @ dense.areas)
    forward = _first_drag(limits, dense.areas, LOADING[-1] * limit)
    tractions = np.array(
        [_first_drag(limits, dense.areas, share * limit) for share in LOADING]
        + [forward - _first_drag(2 * limits, dense.areas, (LOADING[-1] - share) * limit) for share in UNLOADING]
    )
    below = np.abs(tractions) < STUCK * limits
    cells = np.zeros((len(tractions), len(reference.skin)))
    for cell, own in zip(cells, tractions * dense.parts, strict=True):
        cell += np.bincount(dense.taxel, own, len(reference.skin))
    loads = tuple(
        sphere_load(
            dense.link,
            at,
            normal,
            limit / FRICTION,
            RADIUS,
            depth=depth,
            shear=np.array([share * limit, 0.0, 0.0]),
            friction=FRICTION,
        )
        for share in chain(LOADING, UNLOADING)
    )
    return DraggedBall(loads, cells, below @ (limits * dense.areas) / limit, limit)


def _depth(layer: ElasticLayer) -> float:
    """Return the depth of the ball [m] at which a bed bears ``FORCE``, for a paraboloid."""
    return math.sqrt(FORCE / (math.pi * RADIUS * layer.foundation))


def _first_drag(limits: FloatArray, areas: FloatArray, force: float) -> FloatArray:
    """Return the tractions min(limits, c) [Pa] that sum to ``force`` [N], below the largest possible one."""
    pressed = limits > 0
    some = limits[pressed]
    weights = areas[pressed]
    level = brentq(lambda c: float(np.minimum(some, c) @ weights) - force, 0.0, float(some.max()), xtol=1e-9)
    return np.minimum(limits, level)


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every model with every number of taxels and stiffness of the cover."""
    taxels = (100, 1000) if quick else (100, 316, 1000, 3162, 10_000)
    moduli = MODULI_KPA[1:2] if quick else MODULI_KPA
    touches, repeats = (2, 100) if quick else (12, 600)
    return [
        {"taxels": count, "modulus_kpa": kpa, "model": model, "touches": touches, "repeats": repeats, "seed": seed}
        for count in taxels
        for kpa in moduli
        for model in WITH_SHEAR
    ]


def measure(case: Case) -> list[Row]:
    """Return one row: mean errors over touches and states, and times of a reading with and without shear."""
    reference = flat_skin(case["taxels"], case["seed"])
    layer = ElasticLayer(modulus=1e3 * case["modulus_kpa"])
    drags = _drags(case["taxels"], case["modulus_kpa"], case["touches"], case["seed"])
    with_shear, without = (_build(case["model"], reference.skin, layer, shear=shear) for shear in (True, False))
    errors = np.mean([_errors(with_shear, reference.skin, drag) for drag in drags], axis=0)
    loads = [load for drag in drags for load in drag.loads]
    seconds = _time_in_turns((with_shear, without), loads, case["repeats"])
    bare = 1e-3 * bare_step_ms()
    contact = math.sqrt(2 * RADIUS * _depth(layer))
    return [
        {
            "taxels_across": 2 * contact / (SIDE / math.sqrt(case["taxels"])),
            "ms": 1e3 * float(np.median(seconds[0])),
            "p95_ms": 1e3 * float(np.percentile(seconds[0], 95)),
            **dict(zip((kind.key for kind in ERRORS), errors.tolist(), strict=True)),
            "steps": float(np.median(seconds[0])) / bare,
            "shear_steps": float(np.median(seconds[0] - seconds[1])) / bare,
            "step_us": 1e6 * bare,
        }
    ]


def _build(name: str, skin: Skin, layer: ElasticLayer, *, shear: bool) -> PointModel | WaterFillModel:
    """Return a contact model of a flat skin, whose taxels have the axes x and y."""
    model = CONTACT_MODELS[name].build(skin, layer, SensorEffects())
    assert isinstance(model, PointModel | WaterFillModel)
    if shear:
        model.shear = ShearModel(skin, layer, cell_field(skin), np.tile(np.eye(3), (len(skin), 1, 1)))
    return model


def _errors(model: PointModel | WaterFillModel, skin: Skin, drag: DraggedBall) -> FloatArray:
    """Return the errors of all states of a drag, in the order of ``ERRORS``."""
    shear = model.shear
    assert shear is not None
    shear.reset()
    errors = []
    for load, forces, stuck in zip(drag.loads, drag.forces, drag.stuck, strict=True):
        model.pressures([load])
        read = skin.areas[:, None] * shear.tractions
        total = float(np.linalg.norm(read.sum(axis=0) - load.shear[:2]))
        read[:, 0] -= forces
        wrong = float(np.linalg.norm(read, axis=1).sum())
        errors.append((wrong / drag.limit, abs(shear.loads[0].stuck - float(stuck)), total / drag.limit))
    return 100 * np.mean(errors, axis=0)


def _time_in_turns(models: Sequence[ContactModel], loads: Sequence[Load], repeats: int) -> FloatArray:
    """Return the seconds of a reading (models, repeats); in each round every model reads the same load."""
    warm_up = len(loads)
    seconds = np.zeros((len(models), warm_up + repeats))
    for turn in range(warm_up + repeats):
        for number, model in enumerate(models):
            start = time.perf_counter()
            model.pressures([loads[turn % len(loads)]])
            seconds[number, turn] = time.perf_counter() - start
    return seconds[:, warm_up:]


@lru_cache(maxsize=1)
def _drags(taxels: int, modulus_kpa: float, touches: int, seed: int) -> tuple[DraggedBall, ...]:
    """Dragged balls at random places, cached for the models of a cover."""
    reference = flat_skin(taxels, seed)
    layer = ElasticLayer(modulus=1e3 * modulus_kpa)
    places = np.random.default_rng(seed).uniform(-_ASIDE, _ASIDE, (touches, 2))
    return tuple(drag_ball(reference, layer, *place) for place in places.tolist())


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return each error against the time of a reading, for each cover; taxels increase along a curve."""
    return work_precision_figures(
        rows,
        ERRORS,
        panel=lambda row: f"modulus {row['modulus_kpa']} kPa",
        method=lambda row: TITLES[str(row["model"])],
        title="{}, dragged ball",
    )


STUDY = Study(
    "shear-cost",
    "How large is the error of shear by contact model, number of taxels and stiffness of the cover, and what does a "
    "reading cost?",
    f"A ball of {1e3 * RADIUS:.0f} mm is pressed with {FORCE:.0f} N into a flat square of 100 mm with friction "
    f"{FRICTION}, dragged until 95 % of the friction limit, let go, and dragged back with half of the limit. The "
    "reference is a bed of springs with Coulomb friction sampled at 200,000 points. taxels_across is the number of "
    "taxels across the contact. Models are given force, centre and ball, and the tangential force. steps are multiples "
    "of a bare step of our arm in the same run; shear_steps is the part for shear, timed in turns with the same model "
    "without it. The stiffness of the springs along the skin cancels out, because the total force is given: the "
    "stiffness of the cover acts only by the size of the contact.",
    cases,
    measure,
    figures,
)
