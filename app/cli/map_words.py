"""A map's quality in words, for a person at a terminal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from app.cli.output import facts, say


def tell(result: Mapping[str, Any]) -> None:
    """What ``map`` found, the numbers that matter first; then its findings, and the comparison if there is one."""
    facts(
        {
            "Patches": result["patches"],
            "Taxels": result["taxels"],
            "Faces": result["faces"],
            "One-to-one": "yes"
            if result["bijective"]
            else f"no ({result['flips']} flipped triangles, {result['overlaps']} overlaps)",
            "Distortion": f"{result['symmetric_dirichlet']:.4f} (4 is none)",
            "Angles, s1 / s2": _spread(result["angle"]),
            "Areas": _spread(result["area"]),
            "Neighbour distances": f"{_percent(result['edge_error'])} off (rms)",
            "Neighbours torn apart": f"{_percent(result['torn'])} by {result['seam_mm']:.0f} mm of seams",
            "Stress": _number(result["stress"]),
            "Rank correlation": _number(result["spearman"]),
            "Trustworthiness": _number(result["trustworthiness"]),
            "Continuity": _number(result["continuity"]),
            "Round trip": f"{_number(result['round_trip_mm'])} mm through a pixel",
            "Force in the image": f"{_number(result['force_error'])} off (relative)",
            "Time": f"{result['seconds']:.2f} s",
            "Written to": result["file"] or "nothing",
        }
    )
    for finding in result["findings"]:
        facts({f"  {finding['kind']} ({finding['count']}) {finding['where']}": finding["action"]})
    if "comparison" in result:
        _side_by_side(result["comparison"])


def _side_by_side(comparison: Mapping[str, Any]) -> None:
    say("")
    say(f"{'':<34}{'this map':>12}{'the other':>12}")
    marks = {"first": "  this is better", "second": "  the other is better", "neither": ""}
    for row in comparison["measures"]:
        name = row["name"].replace("_", " ")
        say(f"{name:<34}{_number(row['first']):>12}{_number(row['second']):>12}{marks[row['better']]}")
    say(f"{'taxels apart at best fit, rms':<34}{_number(comparison['procrustes_mm']):>12} mm")
    for finding in comparison["findings"]:
        say(f"  {finding['kind']} ({finding['count']}) {finding['where']}: {finding['action']}")


def _spread(values: Mapping[str, float]) -> str:
    return f"{values['median']:.3f} median, {values['p95']:.3f} p95, {values['max']:.3f} max"


def _percent(value: float | None) -> str:
    return "unknown" if value is None else f"{100 * value:.2f} %"


def _number(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.4g}"
