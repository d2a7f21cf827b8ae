"""Timed flattening of patches and its errors, which the stages of cutting and flattening share."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.flattening.methods import METHODS
from tactile_maps.flattening.newton import Iterate
from tactile_maps.maps.build import flatten_patch
from tactile_maps.maps.model.tactile_map import SEAM_RATIO
from tactile_maps.skin.model.skin import Patch
from tactile_maps.studies.study.work_precision import ErrorKind, PatchRecipe, Subject, timed

MOST_ROUNDS = 8
"""Maximum number of rounds of an iterative method that are shown."""
DISTORTION = ErrorKind(
    "distortion", "Distortion", "%", "Distortion energy as an equivalent uniform stretch of all lengths.", 1e-3
)
ERRORS = (
    DISTORTION,
    ErrorKind("angles", "Angles", "°", "Error of the angles of the skin's triangles, root mean square.", 1e-3),
    ErrorKind("torn", "Split neighbours", "%", "Neighbouring taxels at least twice as far apart on the map.", 1e-2),
)


@dataclass(frozen=True, eq=False)
class TimedFlattening:
    """Flattened patches.

    Attributes:
        charts: One chart for each patch.
        rounds: Mean energy over all patches after each round.
        seconds: Time of each round [s]; the last includes all checks.
        iterates: Every round of each patch.
    """

    charts: tuple[Chart, ...]
    rounds: tuple[float, ...]
    seconds: tuple[float, ...]
    iterates: tuple[tuple[Iterate, ...], ...]

    @property
    def note(self) -> str:
        """Actions that were necessary in addition."""
        return "; ".join(dict.fromkeys(finding.action for chart in self.charts for finding in chart.findings))

    @property
    def shown(self) -> list[int]:
        """Numbers of at most ``MOST_ROUNDS`` rounds, evenly over their logarithm, including first and last."""
        count = len(self.rounds)
        return np.unique(np.rint(np.geomspace(1, count, min(count, MOST_ROUNDS))).astype(int) - 1).tolist()


def flatten_timed(
    patches: Sequence[Patch],
    recipes: Iterable[PatchRecipe],
    *,
    repeats: int = 3,
    budget: float = 0.2,
    clock: Callable[[], float] = time.perf_counter,
) -> TimedFlattening:
    """Flatten each patch repeatedly and return the run of median length.

    Args:
        patches: The patches.
        recipes: Recipe of each patch.
        repeats: Maximum number of runs of a patch.
        budget: Time after which no further run begins [s].
        clock: Seconds from any origin.

    Raises:
        MapError: A patch cannot be flattened with its recipe.
    """
    runs = [
        timed(partial(_flatten_once, patch, recipe, clock), repeats=repeats, budget=budget, clock=clock).result
        for patch, recipe in zip(patches, recipes, strict=True)
    ]
    areas = np.array([patch.surface.area for patch in patches])
    count = max(len(seconds) for *_, seconds in runs)
    # The last round is not that of the chart where an additional seam was tried and rejected.
    reached = [[*(each.energy for each in iterates[:-1]), chart.energies[-1]] for chart, iterates, _ in runs]
    # A patch that is finished before another one keeps its last values.
    energies = np.array([[*energy, *(count - len(energy)) * energy[-1:]] for energy in reached])
    seconds = np.array([[*times, *(count - len(times)) * times[-1:]] for *_, times in runs])
    rounds = areas @ energies / areas.sum()
    charts, iterates, _ = zip(*runs, strict=True)
    return TimedFlattening(charts, tuple(rounds.tolist()), tuple(seconds.sum(axis=0).tolist()), iterates)


def _flatten_once(
    patch: Patch, recipe: PatchRecipe, clock: Callable[[], float]
) -> tuple[Chart, tuple[Iterate, ...], list[float]]:
    """The chart, every round, and the time of each round [s]; the last includes all checks."""
    iterates: list[Iterate] = []
    seconds: list[float] = []
    start = clock()

    def note(iterate: Iterate) -> None:
        iterates.append(iterate)
        seconds.append(clock() - start)

    chart = flatten_patch(patch, method=recipe.method, lengths=recipe.lengths, seams=recipe.seams, on_round=note)
    return chart, tuple(iterates), [*seconds[:-1], clock() - start]


def chart_errors(patches: Sequence[Patch], charts: Sequence[Chart], energy: float) -> dict[str, float | None]:
    """Return the errors of charts with mean energy ``energy`` over all patches; ``torn`` is None without neighbours.

    Cost: 5 ms for 20,000 faces.
    """
    pairs = list(zip(patches, charts, strict=True))
    areas = np.concatenate([patch.surface.face_areas for patch in patches])
    angles = np.concatenate([_angle_errors(patch, chart) for patch, chart in pairs])
    torn = np.concatenate([_separated_neighbours(patch, chart) for patch, chart in pairs])
    return {
        "distortion": distortion_percent(energy),
        "angles": float(np.degrees(np.sqrt(np.average(angles, weights=areas)))),
        "torn": 100 * float(torn.mean()) if len(torn) else None,
    }


def distortion_percent(energy: float) -> float:
    """Return the uniform stretch with the same mean energy, 2 (s² + 1/s²) = energy, in percent; 0 for an isometry."""
    half = max(energy, 4.0) / 4
    return 100 * float(np.sqrt(half + np.sqrt(half**2 - 1)) - 1)


def _angle_errors(patch: Patch, chart: Chart) -> FloatArray:
    """(m,) mean square error of the corner angles of each face [rad²]."""
    off = corner_angles(chart.plane[chart.faces]) - corner_angles(patch.surface.vertices[patch.surface.faces])
    return np.asarray((off**2).mean(axis=1))


def corner_angles(triangles: FloatArray) -> FloatArray:
    """Return the corner angles (m, 3) [rad] of triangles (m, 3, d)."""
    along = np.roll(triangles, -1, axis=1) - triangles
    back = np.roll(triangles, 1, axis=1) - triangles
    lengths = np.linalg.norm(along, axis=2) * np.linalg.norm(back, axis=2)
    return np.arccos(np.clip(np.einsum("mcd,mcd->mc", along, back) / np.maximum(lengths, 1e-300), -1, 1))


def _separated_neighbours(patch: Patch, chart: Chart) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """(e,) whether neighbouring taxels are separated."""
    taxels = patch.taxels
    flat = np.einsum("kc,kcd->kd", taxels.weights, chart.plane[chart.faces[taxels.faces]])
    lengths = [np.linalg.norm(np.diff(at[taxels.neighbours], axis=1)[:, 0], axis=1) for at in (flat, taxels.positions)]
    return np.asarray(lengths[0] > SEAM_RATIO * lengths[1])


def seam_plan_fingerprint(plan: SeamPlan) -> str:
    """Return a digest of drawn seams and areas of interest."""
    digest = hashlib.blake2b(plan.drawn.tobytes(), digest_size=8)
    digest.update(b"" if plan.importance is None else plan.importance.tobytes())
    return digest.hexdigest()


def chosen_patches(subject: Subject) -> list[Patch]:
    """Return the selected patches."""
    return [subject.map.skin.patches[number] for number in subject.patches]


def common_recipe(subject: Subject, parameter: Callable[[PatchRecipe], object]) -> PatchRecipe | None:
    """Return the recipe of the patches if its known method and ``parameter`` are the same for all; otherwise None."""
    own = [subject.recipes[number] for number in subject.patches]
    found = {(recipe.method, parameter(recipe)) for recipe in own}
    return own[0] if len(found) == 1 and own[0].method in METHODS else None
