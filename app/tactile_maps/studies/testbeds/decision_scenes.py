"""Scenes with which the decision of effects is tested: the shipped scenes, and variations of their requirements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from types import MappingProxyType
from typing import Any

from tactile_maps.scene.objects import ObjectSpec
from tactile_maps.scene.scene import Scene
from tactile_maps.scene.scene_file import load_scene, scene_names

_BALL = ObjectSpec("ball", "sphere", size=(0.05,), mass=0.3, at=(0.45, 0.0, 0.9))
_FLOOR = ObjectSpec("floor", "plane", size=(2.0, 2.0))
_WALL = ObjectSpec("wall", "box", size=(0.1, 0.1, 0.1), at=(1.5, 0.0, 0.05))

VARIATIONS: Mapping[str, tuple[str, Mapping[str, Any]]] = MappingProxyType(
    {
        "view, torques wanted": ("view", {"outputs": ("posture", "joint_torque")}),
        "poke, force alone": ("poke", {"outputs": ("force",)}),
        "poke, centre wanted": ("poke", {"outputs": ("centre_of_pressure",)}),
        "poke, shape wanted": ("poke", {"outputs": ("pressure_shape",)}),
        "poke, readings wanted": ("poke", {"outputs": ("readings",)}),
        "poke, torques wanted": ("poke", {"outputs": ("posture", "force", "joint_torque")}),
        "poke, force held": ("poke", {"control": {"controller": "hold_force"}}),
        "poke, a wall far away": ("poke", {"objects": (_WALL,)}),
        "arm left alone": ("arm", {"stimuli": ()}),
        "arm under a falling ball": ("arm", {"stimuli": (), "task": "crowd", "objects": (_FLOOR, _BALL)}),
        "slide, torques wanted": ("slide", {"outputs": ("posture", "force", "joint_torque")}),
        "slide, readings wanted": ("slide", {"outputs": ("readings", "force")}),
        "push, readings wanted": ("push_box", {"outputs": ("readings", "posture")}),
        "self-touch, force alone": ("self_touch", {"outputs": ("force",)}),
    }
)
"""Varied scene and changes, by name."""


@cache
def decision_scenes() -> Mapping[str, Scene]:
    """Return all scenes by name, shipped ones first."""
    shipped = {name: load_scene(name) for name in scene_names()}
    varied = {name: replace(shipped[of], name=name, **changes) for name, (of, changes) in VARIATIONS.items()}
    return MappingProxyType(shipped | varied)
