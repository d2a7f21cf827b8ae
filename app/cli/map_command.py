"""``map``: make a tactile map from whatever there is, write it, and say how good it is."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

from app.cli.learn import learned_map, recorded_touch
from app.cli.map_words import tell
from app.cli.output import Progress, answer, progress_line
from app.errors import Finding, MapError, UsageError
from app.maps.body_distances import BodyDistances
from app.maps.build import build_map
from app.maps.compare import TaxelLayout, compare
from app.maps.exchange.obj_uv import read_map_obj
from app.maps.exchange.write import ENDINGS, write_map
from app.maps.hand_made import hand_made
from app.maps.map_file import load_map
from app.maps.methods.table import METHODS
from app.maps.quality import measure
from app.maps.seams import SeamPlan
from app.maps.sources import Wanted, open_skin
from app.maps.tactile_map import TactileMap
from app.skin.exchange.icub_layout import read_icub_layout, with_layout
from app.skin.exchange.module_candidates import propose_modules
from app.skin.exchange.read import read_taxels
from app.skin.placement_spec import BorderStrip, PlacementSpec
from app.skin.skin import Skin


def execute(arguments: argparse.Namespace) -> int:
    """Make the map, write it where asked, report its quality."""
    target = _target(arguments)
    if arguments.method not in METHODS:
        raise UsageError(
            "there is no such method", value=arguments.method, remedy=f"Choose one of: {', '.join(METHODS)}"
        )
    report, start = progress_line(), time.perf_counter()
    skin, map_ = _made(arguments, report)
    seconds = time.perf_counter() - start
    body = BodyDistances(skin)
    result = measure(map_, distances=body).to_json() | {"seconds": seconds, "file": str(target) if target else None}
    if arguments.compare:
        result["comparison"] = _compared(arguments, map_, body)
    if target is not None:
        write_map(map_, target)
    if arguments.json:
        answer(result)
    else:
        tell(result)
    return 0


def _made(arguments: argparse.Namespace, report: Progress) -> tuple[Skin, TactileMap]:
    """The skin and its map."""
    recorded = Path(arguments.input).suffix.lower() == ".mcap"
    skin, readings = recorded_touch(arguments.input) if recorded else (None, None)
    if skin is None:
        skin = open_skin(arguments.input, _wanted(arguments), progress=report)
    if arguments.learn:
        return skin, learned_map(arguments, skin, readings, report)
    return skin, _map(arguments, skin, report)


def _target(arguments: argparse.Namespace) -> Path | None:
    """Where to write; refused before any work is done."""
    if not arguments.output:
        return None
    target = Path(arguments.output)
    if target.suffix.lower() not in ENDINGS:
        endings = ", ".join(ENDINGS)
        raise UsageError(
            "a map is not written as this",
            file=target,
            value=target.suffix or "no ending",
            remedy=f"Choose one of: {endings}",
        )
    if target.is_dir():
        raise MapError("the map cannot be written over a folder", file=target)
    return target


def _wanted(arguments: argparse.Namespace) -> Wanted:
    zones = () if arguments.keep_border is None else (BorderStrip(1e-3 * arguments.keep_border),)
    taxels = None if arguments.pitch is not None or arguments.pattern == "modules" else arguments.taxels
    pitch = None if arguments.pitch is None else 1e-3 * arguments.pitch
    placement = PlacementSpec(pitch, taxels, arguments.pattern, arguments.density, zones, arguments.seed)
    return Wanted(placement, tuple(arguments.links), arguments.robot, arguments.surface)


def _map(arguments: argparse.Namespace, skin: Skin, report: Progress) -> TactileMap:
    """Flattened as asked, or as another program has unwrapped it."""
    if arguments.uv:
        return read_map_obj(arguments.uv, skin)
    plan = None if arguments.seams is None else SeamPlan(extra=arguments.seams)
    seams = {patch.name: plan for patch in skin.patches} if plan else None
    return build_map(skin, method=arguments.method, lengths=arguments.lengths, seams=seams, progress=report)


def _compared(arguments: argparse.Namespace, map_: TactileMap, body: BodyDistances) -> dict[str, Any]:
    """The map beside another of the same skin or one drawn by hand, and what is wrong with the drawing's modules."""
    path, findings = Path(arguments.compare), list[Finding]()
    other: TactileMap | TaxelLayout
    if path.suffix.lower() == ".npz":
        other = load_map(path)
    elif path.suffix.lower() == ".ini":
        taxels, layout = read_taxels(arguments.input), read_icub_layout(path)
        candidates = propose_modules(taxels, layout, seed=arguments.seed)
        findings += [found] if (found := candidates.finding(path.name)) else []
        other = hand_made(
            with_layout(taxels, candidates.apply(layout) if arguments.mend_modules else layout), map_.skin
        )
    else:
        other = hand_made(read_taxels(path), map_.skin)
    result = compare(map_, other, distances=body).to_json()
    return result | {"findings": [vars(finding) for finding in findings]}
