"""What does accuracy cost in flattening a body: which method, with how many seams, on how fine a mesh?"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from app.core.arrays import FloatArray
from app.flattening.chart import Chart
from app.flattening.cut import SeamPlan
from app.flattening.flatten import flatten
from app.flattening.methods import METHODS
from app.flattening.newton import Iterate
from app.geometry.mesh import Mesh
from app.maps.topography import BodyDistances, measure_topography
from app.skin.sampling import place_evenly
from app.skin.skin import Patch, Skin
from app.studies.figures import Figure, Panel
from app.studies.study import Case, Row, Study
from app.studies.testbeds.reference_bodies import MESHES

_MOST_SEAMS = 4
_TAXELS = 150
_ROUNDS = 8
"""At most so many rounds of a method become rows, spread evenly over the logarithm of their number."""


def cases(quick: bool, seed: int) -> list[Case]:
    """Every method on every body: at the middle fineness with 0 to 4 extra seams, at the others without."""
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
    """One row for each of some rounds of the method: seconds from the uncut surface on, and three errors."""
    skin, distances = _body(case["mesh"], case["faces"], case["seed"])
    surface, taxels = skin.patches[0].surface, skin.patches[0].taxels
    runs = [_run(surface, case) for _ in range(case["repeats"])]
    chart, rounds, _ = runs[0]
    seconds = np.median([times for *_, times in runs], axis=0)
    rows: list[Row] = []
    for number in _shown_rounds(len(rounds)):
        # Rounds are told at unit area.
        corners = np.sqrt(surface.area) * rounds[number].plane[chart.faces[taxels.faces]]
        kept = measure_topography(np.einsum("kc,kcd->kd", taxels.weights, corners), distances)
        rows.append(
            {
                "round": number,
                "last": number == len(rounds) - 1,
                "seconds": float(seconds[number]),
                "symmetric_dirichlet": rounds[number].energy,
                "edge_error": kept.edge_error,
                "stress": kept.stress,
                "torn_pairs": kept.torn_pairs,
                "findings": " ".join(finding.kind for finding in chart.findings),
            }
        )
    return rows


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Each error against seconds by method on each body, then what seams and finer meshes bring."""
    plain = [row for row in rows if row["extra_seams"] == 0]
    middle = _middle_fineness(plain)
    base = [row for row in plain if row["faces"] == middle]
    seamed = [row for row in rows if row["faces"] == middle and row["last"]]
    whole = [row for row in plain if row["last"]]
    seconds = "seconds"
    return [
        Figure("Distortion by method, round by round", seconds, "energy - 4", _by(base, "mesh", _excess)),
        Figure("Neighbour distances by method", seconds, "relative error", _by(base, "mesh", _value("edge_error"))),
        Figure("Stress against exact geodesics", seconds, "stress", _by(base, "mesh", _value("stress"))),
        Figure("Distortion with more and more seams", seconds, "energy - 4", _by(seamed, "mesh", _excess)),
        Figure("Distortion on finer and finer meshes", seconds, "energy - 4", _by(whole, "mesh", _excess)),
    ]


@lru_cache(maxsize=4)
def _body(mesh: str, faces: int, seed: int) -> tuple[Skin, BodyDistances]:
    """Kept between the cases of a body: its distances do not depend on the method."""
    surface = MESHES[mesh](faces)
    skin = Skin((Patch(mesh, mesh, surface, place_evenly(surface, min(_TAXELS, len(surface.faces) // 4), seed=seed)),))
    return skin, BodyDistances(skin, seed=seed)


def _run(
    surface: Mesh, case: Case, clock: Callable[[], float] = time.perf_counter
) -> tuple[Chart, list[Iterate], FloatArray]:
    """The chart, every round on the way, and when each was there, the last when all was checked [s]."""
    rounds: list[Iterate] = []
    seconds: list[float] = []
    start = clock()

    def note(iterate: Iterate) -> None:
        rounds.append(iterate)
        seconds.append(clock() - start)

    plan = SeamPlan(case["extra_seams"])
    chart = flatten(surface, method=case["method"], seams=plan, name=case["mesh"], progress=note)
    seconds[-1] = clock() - start
    return chart, rounds, np.array(seconds)


def _shown_rounds(count: int) -> list[int]:
    """Numbers of at most ``_ROUNDS`` of ``count`` rounds, first and last among them."""
    return np.unique(np.rint(np.geomspace(1, count, min(count, _ROUNDS))).astype(int) - 1).tolist()


def _middle_fineness(rows: Sequence[Row]) -> object:
    """The fineness that is nearest to the middle of all."""
    every = sorted({int(row["faces"] or 0) for row in rows})
    return every[len(every) // 2] if every else None


def _by(rows: Sequence[Row], key: str, error: Callable[[Row], float]) -> list[Panel]:
    """One panel for each value of ``key``, in it one curve for each method."""
    return [
        Panel(
            str(value),
            {
                method: [
                    (float(row["seconds"] or 0), error(row))
                    for row in rows
                    if (row[key], row["method"]) == (value, method)
                ]
                for method in METHODS
            },
        )
        for value in dict.fromkeys(row[key] for row in rows)
    ]


def _excess(row: Row) -> float:
    return float(row["symmetric_dirichlet"] or 0) - 4


def _value(key: str) -> Callable[[Row], float]:
    return lambda row: float(row[key] or 0)


STUDY = Study(
    "map-cost",
    "Which way of laying a body flat gives how little distortion in how many seconds?",
    "Each method lays each body flat, cut to a disk and with 0 to 4 seams more, on meshes of about 1000, 4000 "
    "and 16,000 faces. Time runs from the uncut surface; each point is a round of an iterative method, the last one "
    "with the proof that the map is one-to-one. A method whose map is not is mended by our own, which its row says. "
    "Errors: mean symmetric Dirichlet energy (4 is an isometry), rms relative error of the distances between "
    "neighbouring taxels, and stress-1 of 150 taxels against exact geodesics. Times are medians.",
    cases,
    measure,
    figures,
)
