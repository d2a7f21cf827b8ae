"""``map``: make a tactile map and say how good it is."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from app.cli.output import Progress, answer, facts, progress_line
from app.errors import MapError, UsageError
from app.maps.build import build_map
from app.maps.flatten import METHODS
from app.maps.map_file import save_map, save_obj
from app.maps.quality import measure
from app.robots.library import find_robot
from app.skin.cover import cover
from app.skin.cover_spec import CoverSpec
from app.skin.exchange.icub import import_icub
from app.skin.skin import Skin


def execute(arguments: argparse.Namespace) -> int:
    """Make the map, write it where asked, report its quality."""
    target = Path(arguments.output) if arguments.output else None
    if target is not None and target.suffix.lower() not in (".npz", ".obj"):
        raise UsageError("a map is written as .npz or .obj", file=target, value=target.suffix or "no ending")
    if arguments.method not in METHODS:
        raise UsageError("there is no such method", value=arguments.method, remedy=f"Choose {' or '.join(METHODS)}")
    report = progress_line()
    start = time.perf_counter()
    skin, findings = _skin(arguments, report)
    map_ = build_map(skin, method=arguments.method, progress=report)
    seconds = time.perf_counter() - start
    quality = measure(map_)
    if target is not None:
        if target.exists() and target.is_dir():
            raise MapError("the map cannot be written over a folder", file=target)
        (save_obj if target.suffix.lower() == ".obj" else save_map)(map_, target)
    result = quality.to_json() | {"seconds": seconds, "file": str(target) if target else None}
    result["findings"] = [*findings, *result.get("findings", [])]
    if arguments.json:
        answer(result)
    else:
        _tell(result)
    return 0


def _skin(arguments: argparse.Namespace, report: Progress) -> tuple[Skin, list[dict[str, object]]]:
    if Path(arguments.input).suffix.lower() == ".txt":
        robot = find_robot(arguments.robot)
        skin = import_icub(robot, arguments.input, link=arguments.links[0] if arguments.links else None)
    else:
        robot = find_robot(arguments.input)
        skin = cover(robot, CoverSpec(tuple(arguments.links), arguments.taxels, seed=arguments.seed), progress=report)
    return skin, [{"kind": f.kind, "where": f.where, "count": f.count, "action": f.action} for f in robot.findings]


def _tell(result: dict[str, object]) -> None:
    angle, area = result["angle"], result["area"]
    assert isinstance(angle, dict)
    assert isinstance(area, dict)
    facts(
        {
            "Patches": result["patches"],
            "Taxels": result["taxels"],
            "Faces": result["faces"],
            "One-to-one": "yes" if result["bijective"] else f"no ({result['flips']} flipped triangles)",
            "Distortion": f"{result['symmetric_dirichlet']:.4f} (4 is none)",
            "Angles, s1 / s2": f"{angle['median']:.3f} median, {angle['p95']:.3f} p95, {angle['max']:.3f} max",
            "Areas": f"{area['median']:.3f} median, {area['p95']:.3f} p95, {area['max']:.3f} max",
            "Neighbour distances": f"{100 * float(str(result['edge_error'])):.2f} % off (rms)",
            "Stress": result["stress"],
            "Trustworthiness": result["trustworthiness"],
            "Continuity": result["continuity"],
            "Round trip": f"{result['round_trip_mm']} mm",
            "Time": f"{result['seconds']:.2f} s",
            "Written to": result["file"] or "nothing",
        }
    )
    findings = result["findings"]
    assert isinstance(findings, list)
    for finding in findings:
        facts({f"  {finding.get('kind', '')} ({finding.get('count', 1)})": finding.get("action", "")})
