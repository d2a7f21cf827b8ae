"""What does accuracy cost in touch: which contact model, for how many taxels and how small a contact?

Models of ``tactile_maps.tactile`` are given force, centre of pressure and the ball. The contact models that the physics
runs itself (foundation, depth) are given nothing: for them a ball is held where it presses, in a simulation of
nothing else.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache, partial

import mujoco
import numpy as np

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.robot import Link, Robot
from tactile_maps.scene.effects import Effects, SkinModel
from tactile_maps.scene.object_meshes import primitive_mesh
from tactile_maps.scene.objects import ObjectSpec, SceneObject
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.studies.base.figures import Figure
from tactile_maps.studies.base.rows import Case, Row, distinct, scaled
from tactile_maps.studies.stages.touch import ERRORS, Reader, mean_touch_errors, touch_trial
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.study.work_precision import Setting, timed, trial_row, work_precision_figures
from tactile_maps.studies.testbeds.reference_bodies import SIDE
from tactile_maps.studies.testbeds.reference_touch import (
    LENGTH,
    RADIUS,
    REFERENCE_SKINS,
    ReferenceSkin,
    ReferenceTouch,
    displace_ball,
    press_ball,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, Sphere
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS, ContactModel
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects

PHYSICS: Mapping[str, str] = {"foundation": "Foundation", "depth": "Depth"}
"""Models that are given nothing: they see how deep the ball is. As shown to people."""
_FIXED = """<mujoco model="ground"><worldbody><body name="{link}"><geom type="{solid}" pos="{at}" size="{size}"/>
</body></worldbody></mujoco>"""


def hold_ball(ground: ReferenceSkin, model: SkinModel, load: Load) -> Simulation:
    """A simulation of the ball of ``load`` held in the skin of ``ground``, both fixed, before its first step.

    Raises:
        TypeError: What presses is no ball.
    """
    if not isinstance(load.shape, Sphere):
        raise TypeError(f"a ball is meant to press, not {load.shape}")
    x, y, z = load.pose.translation.tolist()
    spec = ObjectSpec("ball", "sphere", (load.shape.radius,), at=(x, y, z))
    effects = Effects(gravity="off", contact="environment", fingers=False, skin=model)
    return Simulation(
        _fixed(ground), ground.skin, effects, objects=(SceneObject(spec, primitive_mesh(spec)),), layer=ElasticLayer()
    )


def step_and_sense(simulation: Simulation) -> FloatArray:
    """One step of the physics and a reading (taxels,) [Pa]: what the taxels say is made in the step."""
    simulation.step(1, _STILL)
    return simulation.sense()


_STILL = JointCommand(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))


def _fixed(ground: ReferenceSkin) -> Robot:
    """A robot of one solid link that cannot move, under the skin of ``ground``."""
    link = ground.skin.patches[0].link
    if np.isinf(ground.radius):
        spec = ObjectSpec(link, "box", (SIDE, SIDE, SIDE))
        at = np.array([SIDE / 2, SIDE / 2, -SIDE / 2])
        solid = "box"
        size = 3 * [SIDE / 2]
    else:
        spec = ObjectSpec(link, "cylinder", (RADIUS, LENGTH))
        at = np.array([0.0, 0.0, LENGTH / 2])
        solid = "cylinder"
        size = [RADIUS, LENGTH / 2]
    mesh = primitive_mesh(spec)
    text = _FIXED.format(link=link, solid=solid, at=_numbers(at), size=_numbers(size))
    body = Link(link, Mesh(mesh.vertices + at, mesh.faces))
    return Robot("ground", "made by formula", text, {}, (body,), (), np.zeros(0))


def _numbers(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:g}" for number in numbers)


TITLES: Mapping[str, str] = {**{name: entry.title for name, entry in CONTACT_MODELS.items()}, **PHYSICS}
"""Of all models, by name."""
CONTACTS_MM = (4, 10, 30)
MISPLACED_MM = (0, 1)
"""How far off models are given the ball's place [mm]; the physics' own are given none."""
_ASIDE = 0.01
"""Touches lie at random up to so far [m] from a skin's middle, where no contact reaches its border."""
_STEPS = 200


def cases(quick: bool, seed: int) -> list[Case]:
    """Every model under every contact at every number of taxels, on a flat skin and a bent one."""
    taxels = (100, 1000) if quick else (100, 316, 1000, 3162, 10_000)
    touches, repeats = (4, 5) if quick else (16, 25)
    return [
        {
            "skin": skin,
            "taxels": count,
            "contact_mm": contact,
            "misplaced_mm": off,
            "model": model,
            "touches": touches,
            "repeats": repeats,
            "seed": seed,
        }
        for skin in REFERENCE_SKINS
        for count in taxels
        for contact in CONTACTS_MM
        for off in MISPLACED_MM
        for model in (CONTACT_MODELS if off else TITLES)
    ]


def measure(case: Case) -> list[Row]:
    """One row: errors over the touches, see ``mean_touch_errors``, and times of a reading."""
    name = case["skin"]
    count = case["taxels"]
    seed = case["seed"]
    skin = REFERENCE_SKINS[name](count, seed).skin
    exact = _reference_touches(name, count, case["contact_mm"], case["touches"], seed)
    touched = [displace_ball(touch, 1e-3 * case["misplaced_mm"]) for touch in exact]
    readers, built = _readers(case, touched)
    repeats = case["touches"] * case["repeats"]
    trial = touch_trial(Setting("touch", case["model"]), readers, touched, skin, repeats=repeats)
    true = mean_touch_errors([touch.surface / skin.areas for touch in touched], touched, skin)
    bare = bare_step_ms()
    return [
        {
            **trial_row(trial),
            "place_mm": trial.errors["place_mm"],
            "exact_place_mm": true["place_mm"],
            "steps": scaled(trial.milliseconds, 1 / bare),
            "step_us": 1e3 * bare,
            "build_ms": 1e3 * built,
        }
    ]


def _readers(case: Case, touched: Sequence[ReferenceTouch]) -> tuple[list[Reader], float]:
    """What reads each touch, and the seconds to build it (of one, where each has its own)."""
    name = case["skin"]
    count = case["taxels"]
    seed = case["seed"]
    if case["model"] in CONTACT_MODELS:
        model, seconds = _model(name, count, case["model"], seed)
        return [partial(model.pressures, [touch.load]) for touch in touched], seconds
    ground = REFERENCE_SKINS[name](count, seed)
    start = time.perf_counter()
    made = [hold_ball(ground, case["model"], touch.load) for touch in touched]
    return [partial(step_and_sense, simulation) for simulation in made], (time.perf_counter() - start) / len(made)


@lru_cache(maxsize=3)
def _reference_touches(name: str, count: int, contact_mm: float, touches: int, seed: int) -> tuple[ReferenceTouch, ...]:
    """Kept between the models of a contact."""
    ground = REFERENCE_SKINS[name](count, seed)
    layer = ElasticLayer()
    blur = ground.blur(layer.depth)
    taxels = len(ground.skin)
    contact = 1e-3 * contact_mm
    places = np.random.default_rng(seed).uniform(-_ASIDE, _ASIDE, (touches, 2))
    return tuple(
        press_ball(ground.dense, *ground.place(*at), contact, taxels=taxels, blur=blur, layer=layer)
        for at in places.tolist()
    )


@lru_cache(maxsize=len(CONTACT_MODELS))
def _model(name: str, count: int, model: str, seed: int) -> tuple[ContactModel, float]:
    """A contact model, kept between the contacts on a skin, and the seconds to build it."""
    skin = REFERENCE_SKINS[name](count, seed).skin
    start = time.perf_counter()
    made = CONTACT_MODELS[model].build(skin, ElasticLayer(), SensorEffects())
    return made, time.perf_counter() - start


@lru_cache(maxsize=1)
def bare_step_ms() -> float:
    """Milliseconds of a step of our own arm with nothing on it, on this machine now."""
    robot = load_robot("arm")
    model = compile_spec(robot_spec(robot), source=robot.source)
    data = mujoco.MjData(model)
    return timed(lambda: mujoco.mj_step(model, data, _STEPS), repeats=25, warm_up=True).ms / _STEPS


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Each error against the time of a reading, for each skin and contact; along a curve the taxels grow."""
    return [
        figure
        for off in distinct(rows, "misplaced_mm")
        for skin in distinct(rows, "skin")
        for figure in work_precision_figures(
            [row for row in rows if (row["misplaced_mm"], row["skin"]) == (off, skin) and "ms" in row],
            ERRORS,
            panel=lambda row: f"contact radius {row['contact_mm']} mm",
            method=lambda row: TITLES[str(row["model"])],
            title=f"{{}}, {skin} skin" + (f", ball {off} mm aside" if off else ""),
        )
    ]


STUDY = Study(
    "touch-cost",
    "How large is the error of each contact model, and what does a reading cost?",
    "A ball is pressed 1 mm into the middle of a flat square of 100 mm and of a tube with a radius of 36 mm, so large "
    "that its contact with a plane has the radius named. The reference is a Winkler foundation (bed of springs) "
    "sampled at 200,000 points; at "
    "the taxels' depth, 2 mm, it is the Boussinesq stress of those forces. Models are given force, centre of "
    "pressure and the ball. A ball given 1 mm aside stands for a collision hull that does not fit the skin. "
    "Shape errors are the forces on the wrong taxels. exact_place_mm is how far off the true forces on the cells put "
    "the centre of pressure: a taxel knows only the sum over its cell, so only a blur can do better. Foundation and "
    "depth are given only where the ball is; theirs is the time of a whole step with its reading. steps are "
    "multiples of a bare step of our arm in the same run.",
    cases,
    measure,
    figures,
)
