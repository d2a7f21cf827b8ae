"""Building the tactile map of a skin, and replacing the chart of one patch."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tactile_maps.core.errors import MapError, MeshError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.methods import find_method
from tactile_maps.flattening.newton import Iterate, OnRound
from tactile_maps.maps.model.layout import MapLayout, pack_charts
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch, Skin


def build_map(
    skin: Skin,
    *,
    method: str = "symmetric-dirichlet",
    lengths: float = 1.0,
    seams: Mapping[str, SeamPlan] | None = None,
    progress: Progress = no_progress,
) -> TactileMap:
    """Cut, flatten and arrange every patch.

    Args:
        skin: Skin with at least one patch.
        method: A name in ``flattening.methods``.
        lengths: 1 keeps lengths, 0 keeps angles; for methods with this parameter.
        seams: Requested seams by patch name.
        progress: Receives the current step and the fraction done, at least once a round; may raise to cancel.

    Raises:
        MapError: No patches, a seam plan for an unknown patch, or a patch that cannot be flattened.
        TypeError: ``skin`` is not a skin, but for example a robot.

    Example:
        >>> tactile_map = tm.build_map(skin)
        >>> tactile_map.taxel_points.shape
        (60, 2)

    Cost: about 30 µs a face; 0.7 s for 1000 taxels on 27,000 faces.
    """
    if not isinstance(skin, Skin):
        remedy = "Cover the robot first: build_map(cover_robot(robot))"
        raise TypeError(f"build_map needs a Skin (found: {type(skin).__name__}). {remedy}")
    plans = seams or {}
    if not skin.patches:
        raise MapError("the skin has no patches to map", remedy="Cover at least one link")
    find_method(method)
    unknown = sorted(set(plans) - {patch.name for patch in skin.patches})
    if unknown:
        names = ", ".join(patch.name for patch in skin.patches)
        raise MapError("seams for an unknown patch", value=unknown[0], remedy=f"Choose among: {names}")
    total = sum(len(patch.surface.faces) for patch in skin.patches)
    charts = []
    done = 0
    for patch in skin.patches:
        text = f"Flattening {patch.name}"
        fraction = done / total

        def report(_iterate: Iterate, text: str = text, fraction: float = fraction) -> None:
            progress(text, fraction)

        progress(text, fraction)
        plan = plans.get(patch.name)
        charts.append(flatten_patch(patch, method=method, lengths=lengths, seams=plan, on_round=report))
        done += len(patch.surface.faces)
    progress("Arranging the map", 1.0)
    return TactileMap(skin, tuple(charts), pack_charts(charts, links=[patch.link for patch in skin.patches]))


def flatten_patch(
    patch: Patch,
    *,
    method: str = "symmetric-dirichlet",
    lengths: float = 1.0,
    seams: SeamPlan | None = None,
    on_round: OnRound | None = None,
) -> Chart:
    """Return the chart of one patch; see ``flatten``. Errors name the patch."""
    try:
        return flatten(patch.surface, method=method, lengths=lengths, seams=seams, name=patch.name, on_round=on_round)
    except (MapError, MeshError) as error:
        raise error.at(kind=MapError, place=f"patch {patch.name}") from error


def with_chart(map_: TactileMap, number: int, chart: Chart) -> TactileMap:
    """Return ``map_`` with another chart for patch ``number`` at the position of the old one.

    The centres of both charts coincide, with the same rotation. The new chart may overlap a neighbour, which
    ``measure`` reports and ``pack_charts`` fixes.

    Raises:
        MapError: The chart belongs to another surface.
    """
    old = map_.charts[number]
    placement = map_.layout.placements[number]
    middle = placement.apply(_middle(old)[None])[0]
    moved = replace(placement, offset=(0.0, 0.0))
    x, y = middle - moved.apply(_middle(chart)[None])[0]
    placements = list(map_.layout.placements)
    placements[number] = replace(moved, offset=(float(x), float(y)))
    charts = list(map_.charts)
    charts[number] = chart
    return TactileMap(map_.skin, tuple(charts), MapLayout(tuple(placements)))


def _middle(chart: Chart) -> np.ndarray:
    return 0.5 * (chart.plane.min(axis=0) + chart.plane.max(axis=0))
