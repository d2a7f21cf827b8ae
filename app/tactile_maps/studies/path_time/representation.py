"""Cost in time of a less accurate representation: knowledge of the skin and its map, and their resolution."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

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
"""Suffix of a learning method that learns from touches with which two places cannot be distinguished."""


def _learned(level: Level) -> Conditions:
    name = str(level)
    return Conditions(map=name.removesuffix(BIASED), touch="biased" if name.endswith(BIASED) else "unbiased")


def _sleeve(name: str, axis: str, levels: Sequence[float], field: str, unit: float, zero: float) -> Factor:
    note = (
        "The path is defined on the skin together with its map: a displaced sleeve displaces every place by the same "
        "amount, for any time. Only the rotation of normals and of directions of the map can cost time."
    )
    return Factor(name, axis, levels, varied(field, unit), levels[1:2], 0.0, drawn_zero=zero, note=note)


def _cover(level: Level) -> Conditions:
    thickness = float(level) * PITCH
    return Conditions(layer=replace(ElasticLayer(), thickness=thickness, depth=thickness / 2))


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
        note="The theoretical l T / (L* e) includes only the readings of the skin. The posture loop adds a lag of 50 "
        "ms, for which the feed-forward of the speed does not compensate: the time is several times longer, and less "
        "so for more tolerance, until the force limits the speed.",
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
        note="The theory covers only the Jacobian of the map, which inverts for single triangles from 2 mm on and "
        "remains valid with two rings of taxels. The normal fails first: with a wrong normal a push slides and a slide "
        "presses, so that the force limits the speed before the Jacobian does. Two rings reduce the error of the "
        "normal to some degrees, a single triangle leaves tens of degrees.",
    ),
    Factor(
        "modules misplaced",
        "mm along each axis (none at 0.25)",
        (1.0, 2.0, 3.0, 5.0, 7.0),
        lambda level: Conditions(misplaced=1e-3 * float(level), by="module"),
        (3.0,),
        0.0,
        drawn_zero=0.25,
    ),
    _sleeve("sleeve shifted", "mm along the link (none at 0.5)", (2.0, 5.0, 10.0), "sleeve_shift", 1e-3, 0.5),
    _sleeve(
        "sleeve turned", "degrees about the link (none at 1)", (5.0, 15.0, 30.0), "sleeve_turn", math.radians(1.0), 1.0
    ),
    Factor(
        "map by geometry",
        "how the map is made",
        (*_GEOMETRIC, ISOMAP),
        chosen("map"),
        ("lscm", ISOMAP),
        Conditions().map,
        jacobians=("smoothed", "isometric"),
    ),
    Factor("map learned", "how the map is learned from touch", _LEARNED, _learned, ("information-distance",)),
    Factor("pitch", "mm between taxels", (4.0, 16.0), varied("pitch", 1e-3), (16.0,), 1e3 * PITCH),
    Factor(
        "cover",
        "thickness over pitch",
        (0.25, 1.0, 2.0),
        _cover,
        (1.0,),
        0.5,
        note="The controller knows the stiffness of the cover. The cover is a bed of springs, which does not spread "
        "loads: a thick cover is soft with a wide contact, and has no blur.",
    ),
    *(
        Factor(
            f"pixel, {name}",
            "mm a pixel (straight from the taxels at 0.25)",
            (0.5, 1.0, 2.0, 4.0, 8.0),
            partial(lambda name, level: Conditions(pixel=1e-3 * float(level), interpolation=name), name),
            (2.0,) if name == "barycentric" else (),
            0.0,
            drawn_zero=0.25,
            note="Pixel size of the image from which the contact centre is computed: the centre of all pixels that the "
            "taxels of the region affect; the force remains pressure times area. At 8 mm, the pitch of the taxels, the "
            "pixels of nearest-taxel interpolation miss some taxels completely.",
        )
        for name in ("barycentric", "nearest", "natural-neighbour")
    ),
    Factor(
        "back-projection",
        "from the contact's centre on the map to the body",
        ("three-taxels",),
        chosen("back_projection"),
        ("three-taxels",),
        Conditions().back_projection,
        jacobians=("smoothed", "raw"),
        note="The error of the path is measured on the map, where both are the same: the back-projection only "
        "determines where the Jacobian and the normal are evaluated.",
    ),
    Factor(
        "curvature",
        "share of places that are flatter (the flattest at 0.25)",
        (0.5, 0.9),
        varied("bend"),
        (0.5,),
        0.0,
        drawn_zero=0.25,
        note="Share among the suitable places, by the largest angle between normals within 20 mm. On a more bent place "
        "the contact is smaller, the normal turns faster along the path, and the joints may move it less well: the "
        "effect of bending alone is measured with the bodies.",
    ),
    Factor(
        "body",
        "body that carries the skin",
        tuple(BODIES),
        chosen("body"),
        (),
        Conditions().body,
        note="Discs of skin of 90 mm above the place of nominal conditions, 30 mm above the link: place and posture "
        "are the same for all, and only the skin is bent. Radii of 80 and 40 mm are 10 and 5 pitches. The figure is 91 "
        "mm long on the map; on the body it is up to 6 % longer on the spheres and as much shorter on the saddles, "
        "whose lengths no map preserves. Pitch and ball are constant: these rows do not separate the effects of pitch "
        "over radius and of the radius of the ball over that of the skin.",
    ),
    Factor(
        "cuts",
        "seams through the place touched (none at 0.5)",
        (1, 2, 3),
        lambda level: Conditions(cuts=int(level)),
        (2,),
        0,
        drawn_zero=0.5,
        note="The figure crosses each cut at least twice; on the map it continues behind the other side.",
    ),
    Factor(
        "dead taxels",
        "share of all (none at 0.005)",
        (0.01, 0.05, 0.1, 0.2),
        sensing(lambda share: SensorEffects(dead_taxels=DeadTaxels(share))),
        (0.1,),
        0.0,
        drawn_zero=0.005,
    ),
)


def measure(case: Case) -> list[Row]:
    """Return one row: the shortest time that meets the tolerances."""
    return measure_case(FACTORS, case)


STUDY = Study(
    "representation",
    "What does it cost in time to know the skin and its map less accurately?",
    METHOD,
    partial(list_cases, FACTORS),
    measure,
    partial(factor_figures, FACTORS),
    OF_REPRESENTATION,
    EFFECT,
    partial(replay_row, FACTORS),
)
