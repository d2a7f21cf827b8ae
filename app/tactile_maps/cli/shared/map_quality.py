"""Measures of a map as the lines of a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from tactile_maps.core.errors import counted


def quality_fields(result: Mapping[str, Any]) -> dict[str, str]:
    """Return the lines of the table by title.

    Args:
        result: JSON of the measures, as ``MapQuality.to_json`` returns it.
    """
    return {
        "Faces": str(result["faces"]),
        "One-to-one": "yes"
        if result["bijective"]
        else f"no ({counted(result['flips'], 'flipped triangle')}, {counted(result['overlaps'], 'overlap')})",
        "Distortion": "infinite: a face has no area on the map"
        if result["symmetric_dirichlet"] is None
        else f"{result['symmetric_dirichlet']:.4f} (4 is isometric)",
        "Angles, s1 / s2": _spread_text(result["angle"]),
        "Areas": _spread_text(result["area"]),
        "Neighbour distances": f"{_percent_text(result['edge_error'])} off (rms)",
        "Split neighbours": f"{_percent_text(result['torn'])} on {result['seam_mm']:.0f} mm of seams",
        "Stress": number_text(result["stress"]),
        "Rank correlation": number_text(result["spearman"]),
        "Trustworthiness": number_text(result["trustworthiness"]),
        "Continuity": number_text(result["continuity"]),
        "Round-trip error": f"{number_text(result['round_trip_mm'])} mm through a pixel",
        "Force error of the image": f"{number_text(result['force_error'])} off (relative)",
    }


def _spread_text(values: Mapping[str, float | None]) -> str:
    """Spread of values; null is infinite, which JSON lacks: a face that the map degenerates to a line."""
    return ", ".join(f"{'infinite' if value is None else f'{value:.3f}'} {name}" for name, value in values.items())


def _percent_text(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.2f} %"


def number_text(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4g}"
