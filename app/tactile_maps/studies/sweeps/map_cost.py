"""What does accuracy cost in flattening a body, by method, number of seams and fineness of the mesh?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.evaluation.topography import BodyDistances, measure_topography
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.studies.base.figures import Figure
from tactile_maps.studies.base.rows import Case, Row
from tactile_maps.studies.stages.timed_flattening import DISTORTION, distortion_percent, flatten_timed
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.study.work_precision import (
    ErrorKind,
    PatchRecipe,
    Setting,
    Trial,
    trial_row,
    work_precision_figures,
)
from tactile_maps.studies.testbeds.reference_bodies import MESHES

ERRORS = (
    DISTORTION,
    ErrorKind("edge_error", "Neighbour distances", "relative error", "Between neighbouring taxels, rms.", 1e-6),
    ErrorKind("stress", "Stress", "stress-1", "Of distances on the map against exact geodesics.", 1e-6),
)
_MOST_SEAMS = 4
_TAXELS = 150


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every method on every body: with 0 to 4 extra seams at the middle fineness, without at the others."""
    if quick:
        settings = [("tube", 600, 0), ("hemisphere", 600, 0), ("hemisphere", 600, 1)]
    else:
        settings = [(mesh, 4000, seams) for mesh in MESHES for seams in range(_MOST_SEAMS + 1)]
        settings += [(mesh, faces, 0) for mesh in MESHES for faces in (1000, 16_000)]
    repeats = 1 if quick else 3
    return [
        {"mesh": mesh, "faces": faces, "extra_seams": seams, "method": method, "repeats": repeats, "seed": seed}
        for mesh, faces, seams in settings
        for method in METHODS
    ]


def measure(case: Case) -> list[Row]:
    """Return one row for each of some rounds of the method: the time since the uncut surface, and its errors."""
    skin, distances = _body(case["mesh"], case["faces"], case["seed"])
    surface = skin.patches[0].surface
    taxels = skin.patches[0].taxels
    recipe = PatchRecipe(case["method"], seams=SeamPlan(case["extra_seams"]))
    flattened = flatten_timed(skin.patches, [recipe], repeats=case["repeats"], budget=math.inf)
    ((chart,), (rounds,)) = flattened.charts, flattened.iterates
    rows: list[Row] = []
    for number in flattened.shown:
        # Rounds are normalised to unit area.
        corners = np.sqrt(surface.area) * rounds[number].plane[chart.faces[taxels.faces]]
        kept = measure_topography(np.einsum("kc,kcd->kd", taxels.weights, corners), distances)
        errors = {
            "distortion": distortion_percent(flattened.rounds[number]),
            "edge_error": kept.edge_error,
            "stress": kept.stress,
        }
        setting = Setting("flatten", case["method"])
        trial = Trial(setting, "", 1e3 * flattened.seconds[number], errors, flattened.note)
        rows.append(
            {
                "round": number,
                "last": number == len(rounds) - 1,
                **trial_row(trial),
                "symmetric_dirichlet": flattened.rounds[number],
                "torn_pairs": kept.torn_pairs,
                "findings": " ".join(finding.kind for finding in chart.findings),
            }
        )
    return rows


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return each error against time by method on each body, round by round, then with seams and with finer meshes."""
    plain = [row for row in rows if row["extra_seams"] == 0]
    middle = _middle_fineness(plain)
    base = [row for row in plain if row["faces"] == middle]
    seamed = [row for row in rows if row["faces"] == middle and row["last"]]
    whole = [row for row in plain if row["last"]]
    selections = [
        (base, ERRORS, "{} by method"),
        (seamed, ERRORS[:1], "{} with more and more seams"),
        (whole, ERRORS[:1], "{} on finer and finer meshes"),
    ]
    return [
        figure
        for selected, errors, title in selections
        for figure in work_precision_figures(selected, errors, panel=lambda row: str(row["mesh"]), title=title)
    ]


@lru_cache(maxsize=4)
def _body(mesh: str, faces: int, seed: int) -> tuple[Skin, BodyDistances]:
    """Body and its distances, which do not depend on the method; cached for the cases of the body."""
    surface = MESHES[mesh](faces)
    skin = Skin((Patch(mesh, mesh, surface, place_evenly(surface, min(_TAXELS, len(surface.faces) // 4), seed=seed)),))
    return skin, BodyDistances(skin, sources=12, seed=seed)


def _middle_fineness(rows: Sequence[Row]) -> object:
    """The middle of the sorted finenesses."""
    every = sorted({int(row["faces"] or 0) for row in rows})
    return every[len(every) // 2] if every else None


STUDY = Study(
    "map-cost",
    "How much distortion does each flattening method leave, and in what time?",
    "Each method flattens each body, cut to a disk and with 0 to 4 additional seams, on meshes of about 1000, 4000 "
    "and 16,000 faces. Time starts at the uncut surface; each point is a round of an iterative method, the last one "
    "with the proof that the map is one-to-one. A map that is not is repaired by our own method, which its row states. "
    "Errors: mean symmetric Dirichlet energy (4 is an isometry) and the equivalent uniform stretch in percent, rms "
    "relative error of the distances between neighbouring taxels, and stress-1 of 150 taxels against exact geodesics. "
    "Times are those of the run of median length.",
    cases,
    measure,
    figures,
)
