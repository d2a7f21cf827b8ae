"""``inspect``: what a robot, skin, map, scene or recording holds, and what is wrong with it."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from app.cli.output import answer, facts, say
from app.errors import Finding, TactileMapsError
from app.maps.map_file import load_map
from app.maps.quality import measure
from app.recording.player import Player
from app.robots.library import find_robot
from app.robots.robot import Robot
from app.session.prepare import prepare
from app.session.session import Session
from app.simulation.scene import Scene, effect_rows
from app.simulation.scene_file import load_scene, scene_names
from app.skin.exchange.icub_layout import read_icub_layout
from app.skin.exchange.read import read_taxel_sets
from app.skin.skin import Skin
from app.skin.skin_file import load_skin


def execute(arguments: argparse.Namespace) -> int:
    """Open whatever it is and describe it."""
    found = describe(arguments.input)
    if arguments.json:
        answer(found)
        return 0
    plain = {key.capitalize(): _text(value) for key, value in found.items() if key not in ("effects", "problems")}
    facts(plain)
    for row in found.get("effects", ()):
        cost = f", {row['ms']:.3f} ms a tick" if row["ms"] is not None else ""
        say(f"  {row['name']}: {'on' if row['on'] else 'off'}, {row['why']}{cost}")
    for problem in found["problems"]:
        say(f"  {problem['kind']} ({problem['count']}) {problem['where']}: {problem['remedy']}")
    return 0


def describe(name: str) -> dict[str, Any]:
    """What ``name`` is, by its ending; names of scenes come before names of robots.

    Raises:
        TactileMapsError: It is none of them, or broken.
    """
    ending = Path(name).suffix.lower()
    if ending == ".mcap":
        return _recording(name)
    if ending == ".npz":
        return _arrays(name)
    if ending in (".txt", ".csv", ".tsv", ".json"):
        return _taxel_file(name)
    if ending == ".ini":
        return _layout(name)
    if ending == ".toml" or name in scene_names():
        return _scene(load_scene(name))
    return {"kind": "robot", **_robot(find_robot(name))}


def _robot(robot: Robot) -> dict[str, Any]:
    return {
        "name": robot.name,
        "source": robot.source,
        "links": [link.name for link in robot.links],
        "joints": [joint.name for joint in robot.joints],
        "bodies": len(robot.links),
        "problems": _problems(robot.findings),
    }


def _skin(skin: Skin) -> dict[str, Any]:
    return {
        "taxels": len(skin),
        "patches": [
            {"name": patch.name, "link": patch.link, "taxels": len(patch.taxels), "cm2": 1e4 * patch.surface.area}
            for patch in skin.patches
        ],
    }


def _scene(scene: Scene) -> dict[str, Any]:
    prepared = prepare(scene)
    session = Session(prepared)
    for _ in range(round(1.0 / scene.tick)):
        session.tick()
    milliseconds = session.frame.timings.ms
    costs = {"fingers": milliseconds.get("physics"), "skin pressure (water-fill)": milliseconds.get("touch")}
    effects = [
        {"name": row.name, "on": row.on, "why": row.why, "ms": costs.get(row.name)} for row in effect_rows(scene)
    ]
    problems = _problems((*prepared.robot.findings, *prepared.skin.findings))
    robot = _robot(prepared.robot)
    return {
        "kind": "scene",
        **robot,
        "name": scene.name,
        "title": scene.title,
        "robot": scene.robot,
        **_skin(prepared.skin),
        "effects": effects,
        "problems": problems,
    }


def _recording(name: str) -> dict[str, Any]:
    player = Player(name)
    problems = (
        []
        if player.complete
        else [{"kind": "cut-off", "where": name, "remedy": f"tactile-maps recover {name} -o fixed.mcap", "count": 1}]
    )
    return {
        "kind": "recording",
        "name": player.prepared.scene.name,
        "robot": player.prepared.robot.name,
        "links": [link.name for link in player.prepared.robot.links],
        "joints": [joint.name for joint in player.prepared.robot.joints],
        **_skin(player.prepared.skin),
        "frames": len(player),
        "seconds": player.duration,
        "inputs": len(player.inputs),
        "versions": player.versions,
        "problems": problems,
    }


def _arrays(name: str) -> dict[str, Any]:
    """A map, or failing that a skin; both are npz."""
    try:
        map_ = load_map(name)
    except TactileMapsError as not_a_map:
        try:
            skin = load_skin(name)
        except TactileMapsError:
            raise not_a_map from None
        return {"kind": "skin", "name": Path(name).stem, **_skin(skin), "problems": _problems(skin.findings)}
    return {
        "kind": "map",
        "name": Path(name).stem,
        **_skin(map_.skin),
        "quality": measure(map_).to_json(),
        "problems": _problems(map_.skin.findings),
    }


def _taxel_file(name: str) -> dict[str, Any]:
    sets = read_taxel_sets(name)
    return {
        "kind": "taxel file",
        "name": Path(name).stem,
        "links": [taxels.link for taxels in sets],
        "taxels": sum(map(len, sets)),
        "mapped": sum(int(taxels.mapped.sum()) for taxels in sets),
        "problems": _problems(finding for taxels in sets for finding in taxels.findings),
    }


def _layout(name: str) -> dict[str, Any]:
    layout = read_icub_layout(name)
    return {
        "kind": "layout",
        "name": layout.name,
        "modules": len(layout.modules),
        "taxels": len(layout.numbers),
        "problems": _problems(layout.findings),
    }


def _problems(findings: Iterable[Finding]) -> list[dict[str, Any]]:
    return [{"kind": f.kind, "where": f.where, "remedy": f.action, "count": f.count} for f in findings]


def _text(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {item}" for key, item in value.items())
    if isinstance(value, list):
        return ", ".join(
            f"{item['name']} ({item['taxels']} taxels)" if isinstance(item, dict) else str(item) for item in value
        )
    return str(value)
