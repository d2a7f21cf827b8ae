"""How much each further seam would gain: the curve by which a person chooses how many."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from app.geometry.mesh import Mesh
from app.maps.chart import Chart
from app.maps.flatten import flatten
from app.maps.seams import SeamPlan


@dataclass(frozen=True, eq=False)
class SeamStep:
    """A patch with some number of extra seams.

    Attributes:
        extra: How many.
        energy: Mean symmetric Dirichlet energy; 4 is an isometry.
        length: Of all seams on the body [m].
        chart: The patch, cut and laid flat so.
    """

    extra: int
    energy: float
    length: float
    chart: Chart


def seam_curve(
    surface: Mesh, *, most: int = 5, plan: SeamPlan | None = None, method: str = "symmetric-dirichlet"
) -> Iterator[SeamStep]:
    """The patch with 0, 1, ... ``most`` extra seams: number of cuts against distortion, told as it is computed.

    Args:
        surface: As for ``flatten``.
        most: Extra seams at the end of the curve.
        plan: Drawn seams and areas of interest that hold throughout; its ``extra`` does not matter.
        method: See ``methods.table``.

    Raises:
        MapError: The surface cannot be laid flat with any of these.
    """
    given = plan or SeamPlan()
    for extra in range(most + 1):
        chart = flatten(surface, method=method, seams=SeamPlan(extra, given.drawn, given.importance))
        ends = surface.vertices[chart.seams]
        length = float(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum())
        yield SeamStep(extra, chart.energies[-1], length, chart)
