"""``weigh``: put a known weight on the skin and compare the reading with it."""

from __future__ import annotations

import argparse
from pathlib import Path

from tactile_maps.cli.shared.output import print_result, progress_line
from tactile_maps.cli.shared.robot_options import package_roots
from tactile_maps.cli.shared.scenes import with_home
from tactile_maps.core.errors import UsageError, did_you_mean
from tactile_maps.scene.effects import EFFECTS
from tactile_maps.scene.scene import with_package_roots
from tactile_maps.scene.scene_file import scene_for, scene_names
from tactile_maps.session.prepare import load_robot_and_skin, open_scene
from tactile_maps.simulation.known_load_check import WeighingResult, weigh
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS

TOLERANCE = 0.02
"""Largest relative error at which the check passes."""


def execute(arguments: argparse.Namespace) -> int:
    """Weigh on the skin of a scene or robot; return 1 if the error exceeds ``TOLERANCE``."""
    name = arguments.input
    models = tuple(name for name in EFFECTS["skin"].words if name != "off")
    if arguments.model is not None and arguments.model not in models and arguments.model not in CONTACT_MODELS:
        every = tuple(name for name in EFFECTS["skin"].choices if name != "off")
        remedy = did_you_mean(arguments.model, every)
        raise UsageError("unknown contact model", place="--model", value=arguments.model, remedy=remedy)
    roots = package_roots(arguments)
    is_scene = Path(name).suffix.lower() == ".toml" or name in scene_names()
    scene = open_scene(name, package_roots=roots) if is_scene else with_package_roots(scene_for(name), roots)
    scene = with_home(scene, arguments)
    usual = "water-fill" if scene.effects.skin == "off" else scene.effects.skin
    progress = progress_line()
    robot, skin = load_robot_and_skin(scene, progress=progress)
    progress("Weighing", 0.5)
    weighed = weigh(robot, skin, scene.layer, arguments.model or usual, mass=arguments.mass)
    progress("", 1.0)
    good = abs(weighed.error) <= TOLERANCE
    _print_result(arguments, weighed, good)
    return 0 if good else 1


def _print_result(arguments: argparse.Namespace, weighed: WeighingResult, good: bool) -> None:
    facts = {
        "Known load": f"{arguments.mass:g} kg, {weighed.expected_N:.3f} N",
        "Measured": f"{weighed.read_N:.3f} N with {weighed.model}",
        "Error": f"{100 * weighed.error:+.2f} %, {'passed' if good else f'more than {100 * TOLERANCE:g} %'}",
        "On": weighed.patch,
        "Settled after": f"{weighed.seconds:.2f} s",
    }
    if arguments.report:
        from tactile_maps.cli.shared.pages import write_fact_page

        write_fact_page(arguments.report, f"Known load on {arguments.input}", facts)
    result = {**vars(weighed), "mass": arguments.mass, "good": good}
    print_result(result, {**facts, "Written to": arguments.report}, as_json=arguments.json)
