"""``map``: make a tactile map from whatever there is, write it, and say how good it is."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np

from app.arrays import FloatArray
from app.cli.learn import learned_map, recorded_touch
from app.cli.map_words import tell
from app.cli.output import Progress, answer, progress_line
from app.errors import MapError, UsageError
from app.maps.body_distances import BodyDistances
from app.maps.build import build_map
from app.maps.compare import TaxelLayout, compare
from app.maps.exchange.obj_uv import read_map_obj
from app.maps.exchange.write import ENDINGS, write_map
from app.maps.map_file import load_map
from app.maps.methods.table import METHODS
from app.maps.quality import measure
from app.maps.seams import SeamPlan
from app.maps.sources import Wanted, open_skin
from app.maps.tactile_map import TactileMap
from app.skin.exchange.icub_layout import read_icub_layout, with_layout
from app.skin.exchange.read import read_taxels
from app.skin.exchange.taxel_set import TaxelSet
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
        result["comparison"] = compare(map_, _other(arguments, skin), distances=body).to_json()
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


def _other(arguments: argparse.Namespace, skin: Skin) -> TactileMap | TaxelLayout:
    """What to compare with: a map of the same skin, or a layout drawn by hand."""
    path = Path(arguments.compare)
    if path.suffix.lower() == ".npz":
        return load_map(path)
    if path.suffix.lower() == ".ini":
        taxels = with_layout(read_taxels(arguments.input), read_icub_layout(path))
    else:
        taxels = read_taxels(path)
    return hand_made(taxels, skin, path)


def hand_made(taxels: TaxelSet, skin: Skin, path: Path) -> TaxelLayout:
    """The file's map points, each given to the taxel of the skin nearest to it on the body."""
    points = taxels.points
    if points is None:
        raise MapError(
            "the file has no map points to compare with", file=path, remedy="Give columns u and v, or a layout"
        )
    known = np.isfinite(points).all(axis=1)
    return TaxelLayout(points[known], _nearest(skin, taxels.positions[known]))


def _nearest(skin: Skin, positions: FloatArray) -> Any:
    own = np.concatenate([patch.taxels.positions for patch in skin.patches])
    return np.linalg.norm(positions[:, None] - own[None], axis=2).argmin(axis=1)
