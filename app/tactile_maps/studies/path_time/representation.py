"""What accuracy of the representation costs in time: how well a skin and its map are known, and how fine they are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Literal

from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.learned.methods import LEARNING_METHODS
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.path_time.charts import factor_figures
from tactile_maps.studies.path_time.conditions import PITCH, Conditions
from tactile_maps.studies.path_time.expectations import EFFECT, OF_REPRESENTATION
from tactile_maps.studies.path_time.factors import Factor, Level, chosen, sensing, varied
from tactile_maps.studies.path_time.path_time import METHOD, list_cases, measure_case
from tactile_maps.studies.path_time.replay import replay_row
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.testbeds.bent_skin import BODIES
from tactile_maps.studies.testbeds.isomap import ISOMAP
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.sensors.sensor_effects import DeadTaxels, SensorEffects

BIASED = ", two far places always touched together"
"""After the name of a way to learn: touch from which neighbourhood cannot be told."""


def _learned(level: Level) -> Conditions:
    name = str(level)
    return Conditions(map=name.removesuffix(BIASED), touch="biased" if name.endswith(BIASED) else "unbiased")


def _modules(level: Level) -> Conditions:
    return Conditions(misplaced=1e-3 * float(level), by="module")


def _sleeve(name: Literal["sleeve_shift", "sleeve_turn"], unit: float) -> Factor:
    shift = name == "sleeve_shift"
    return Factor(
        "sleeve shifted" if shift else "sleeve turned",
        "mm along the link (none at 0.5)" if shift else "degrees about the link (none at 1)",
        (2.0, 5.0, 10.0) if shift else (5.0, 15.0, 30.0),
        varied(name, unit),
        (5.0,) if shift else (15.0,),
        0.0,
        drawn_zero=0.5 if shift else 1.0,
        note="The path lies on the skin, which is one with its map: a sleeve that sits elsewhere has every place off "
        "by just that, whatever the time. What can cost time is that normals and ways of the map are turned.",
    )


def _cover(level: Level) -> Conditions:
    thickness = float(level) * PITCH
    return Conditions(layer=replace(ElasticLayer(), thickness=thickness, depth=thickness / 2))


def _pixels(interpolation: str, level: Level) -> Conditions:
    return Conditions(pixel=1e-3 * float(level), interpolation=interpolation)


def _cuts(level: Level) -> Conditions:
    return Conditions(cuts=int(level))


_GEOMETRIC = tuple(name for name in METHODS if name != Conditions().map)
_LEARNED = tuple(f"{name}{touch}" for name in LEARNING_METHODS for touch in ("", BIASED))
FACTORS: Sequence[Factor] = (
    Factor(
        "tolerance",
        "mm, 95 % of the errors within",
        (1.0, 1.5, 2.0, 5.0),
        varied("tolerance", 1e-3),
        (5.0,),
        3.0,
        note="Theory's l T / (L* e) counts the skin's readings alone. Here the posture loop lags by 50 ms besides, "
        "which the path's speed, fed forward, does not make good: so it takes several times longer, and less so for "
        "more tolerance, until it is the force that limits.",
    ),
    Factor(
        "taxels misplaced",
        "mm along each axis (none at 0.25)",
        (0.5, 1.0, 2.0, 3.0, 5.0, 7.0),
        varied("misplaced", 1e-3),
        (3.0,),
        0.0,
        jacobians=("smoothed", "raw", "isometric"),
        drawn_zero=0.25,
        note="The theory covers the map's Jacobian alone, which inverts for single triangles from 2 mm on and with two "
        "rings of taxels does not. The normal is wrong sooner: along a wrong one a push slides and a slide presses, so "
        "that the force limits the speed before the Jacobian does; two rings keep some degrees of the error where a "
        "triangle keeps tens.",
    ),
    Factor("modules misplaced", "mm along each axis (none at 0.25)", (1.0, 2.0, 3.0, 5.0, 7.0), _modules, (3.0,), 0.0,
           drawn_zero=0.25),
    _sleeve("sleeve_shift", 1e-3),
    _sleeve("sleeve_turn", math.radians(1.0)),
    Factor("map by geometry", "how the map is made", (*_GEOMETRIC, ISOMAP), chosen("map"), ("lscm", ISOMAP),
           Conditions().map, jacobians=("smoothed", "isometric")),
    Factor("map learned", "how the map is learned from touch", _LEARNED, _learned, ("information-distance",)),
    Factor("pitch", "mm between taxels", (4.0, 16.0), varied("pitch", 1e-3), (16.0,), 1e3 * PITCH),
    Factor(
        "cover",
        "thickness over pitch",
        (0.25, 1.0, 2.0),
        _cover,
        (1.0,),
        0.5,
        note="The controller is told how stiff the cover is. The bed of springs that the cover is here spreads no load "
        "aside: a thick cover is a soft one and a wide contact, and blurs nothing.",
    ),
    *(
        Factor(
            f"pixel, {name}",
            "mm a pixel (straight from the taxels at 0.25)",
            (0.5, 1.0, 2.0, 4.0, 8.0),
            partial(_pixels, name),
            (2.0,) if name == "barycentric" else (),
            0.0,
            drawn_zero=0.25,
            note="Of the image that the contact's centre is taken from: it is that of all pixels which the region's "
            "taxels reach; the force stays pressure times area. At 8 mm, the taxels' own pitch, the nearest taxel's "
            "pixels show some taxels not at all.",
        )
        for name in ("barycentric", "nearest", "natural-neighbour")
    ),
    Factor("back-projection", "from the contact's centre on the map to the body", ("three-taxels",),
           chosen("back_projection"), ("three-taxels",), Conditions().back_projection, jacobians=("smoothed", "raw"),
           note="The error of the path is taken on the map, where both are the same: what comes back to the body only "
           "says where the Jacobian and the normal are asked for."),
    Factor(
        "curvature",
        "share of places that are flatter (the flattest at 0.25)",
        (0.5, 0.9),
        varied("bend"),
        (0.5,),
        0.0,
        drawn_zero=0.25,
        note="Of the places fit to be touched, by the greatest angle between normals within 20 mm. A more bent one "
        "touches the ball with less skin, its normal turns faster along the way, and the joints may move it less well: "
        "what bending alone does is asked of the bodies.",
    ),
    Factor(
        "body",
        "what bears the skin",
        tuple(BODIES),
        chosen("body"),
        (),
        Conditions().body,
        note="Discs of skin of 90 mm over the place of nominal conditions, 30 mm above the link: place and posture are "
        "the same for all, what bends is the skin alone. Radii of 80 and 40 mm are 10 and 5 pitches. The figure is 91 "
        "mm long on the map; on the body it is up to 6 % longer on the spheres and as much shorter on the saddles, "
        "whose lengths no map keeps. Pitch and ball are the same throughout: what of it is pitch over radius, and what "
        "the ball's radius over the skin's, these rows do not tell.",
    ),
    Factor(
        "cuts",
        "seams through the place touched (none at 0.5)",
        (1, 2, 3),
        _cuts,
        (2,),
        0,
        drawn_zero=0.5,
        note="The figure leads over each cut twice or more; on the map it goes on behind the other side.",
    ),
    Factor("dead taxels", "share of all (none at 0.005)", (0.01, 0.05, 0.1, 0.2),
           sensing(lambda share: SensorEffects(dead_taxels=DeadTaxels(share))), (0.1,), 0.0, drawn_zero=0.005),
)  # fmt: skip


def measure(case: Case) -> list[Row]:
    """One row: the shortest time that is well enough."""
    return measure_case(FACTORS, case)


STUDY = Study(
    "representation",
    "What does it cost in time to know the skin and its map less well?",
    METHOD,
    partial(list_cases, FACTORS),
    measure,
    partial(factor_figures, FACTORS),
    OF_REPRESENTATION,
    EFFECT,
    partial(replay_row, FACTORS),
)
