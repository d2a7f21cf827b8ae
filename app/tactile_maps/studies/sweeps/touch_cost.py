"""What does accuracy cost in touch, by contact model, number of taxels and size of the contact?

Models of ``tactile_maps.tactile`` are given force, centre of pressure and the ball. The contact models of the physics
(foundation, depth) receive no load: a ball is held in the skin in a simulation without anything else.
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
from tactile_maps.studies.stages.touch import ERRORS, ReadPressures, mean_touch_errors, touch_trial
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
"""Displayed names of the models within the physics, which sense the depth of the ball themselves."""
_FIXED = """<mujoco model="block"><worldbody><body name="{link}"><geom type="{solid}" pos="{at}" size="{size}"/>
</body></worldbody></mujoco>"""


def hold_ball(reference: ReferenceSkin, model: SkinModel, load: Load) -> Simulation:
    """Return a simulation of the ball of ``load`` held in the skin of ``reference``, both fixed, before its first step.

    Raises:
        TypeError: The shape of the load is not a ball.
    """
    if not isinstance(load.shape, Sphere):
        raise TypeError(f"a ball is required, not {load.shape}")
    x, y, z = load.pose.translation.tolist()
    spec = ObjectSpec("ball", "sphere", (load.shape.radius,), at=(x, y, z))
    effects = Effects(gravity="off", contact="environment", fingers=False, skin=model)
    ball = SceneObject(spec, primitive_mesh(spec))
    return Simulation(_fixed(reference), reference.skin, effects, objects=(ball,), layer=ElasticLayer())


def step_and_sense(simulation: Simulation) -> FloatArray:
    """Step the physics once and return its reading (taxels,) [Pa], which is computed in the step."""
    simulation.step(1, _STILL)
    return simulation.sense()


_STILL = JointCommand(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros(0))


def _fixed(reference: ReferenceSkin) -> Robot:
    """A robot of one solid link that cannot move, under the skin of ``reference``."""
    link = reference.skin.patches[0].link
    if np.isinf(reference.radius):
        spec = ObjectSpec(link, "box", (SIDE, SIDE, SIDE))
        at = np.array([SIDE / 2, SIDE / 2, -SIDE / 2])
        size = 3 * [SIDE / 2]
    else:
        spec = ObjectSpec(link, "cylinder", (RADIUS, LENGTH))
        at = np.array([0.0, 0.0, LENGTH / 2])
        size = [RADIUS, LENGTH / 2]
    mesh = primitive_mesh(spec)
    text = _FIXED.format(link=link, solid=spec.kind, at=_numbers(at), size=_numbers(size))
    body = Link(link, Mesh(mesh.vertices + at, mesh.faces))
    return Robot("block", "made by formula", text, {}, (body,), (), np.zeros(0))


def _numbers(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:g}" for number in numbers)


TITLES: Mapping[str, str] = {**{name: entry.title for name, entry in CONTACT_MODELS.items()}, **PHYSICS}
"""Displayed names of all models."""
CONTACTS_MM = (4, 10, 30)
MISPLACED_MM = (0, 1)
"""Error of the position of the ball that models are given [mm]; models of the physics are given none."""
_ASIDE = 0.01
"""Maximum distance of the touches from the middle of a skin along each axis [m]; no contact reaches the border."""
_STEPS = 200


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every model with every contact and number of taxels, on a flat and on a bent skin."""
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
    """Return one row: mean errors over the touches (``mean_touch_errors``) and times of a reading."""
    name = case["skin"]
    count = case["taxels"]
    seed = case["seed"]
    skin = REFERENCE_SKINS[name](count, seed).skin
    exact = _reference_touches(name, count, case["contact_mm"], case["touches"], seed)
    touched = [displace_ball(touch, 1e-3 * case["misplaced_mm"]) for touch in exact]
    reads, built = _reads(case, touched)
    repeats = case["touches"] * case["repeats"]
    trial = touch_trial(Setting("touch", case["model"]), reads, touched, skin, repeats=repeats)
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


def _reads(case: Case, touched: Sequence[ReferenceTouch]) -> tuple[list[ReadPressures], float]:
    """Functions that read each touch, and the seconds to build one model."""
    name = case["skin"]
    count = case["taxels"]
    seed = case["seed"]
    if case["model"] in CONTACT_MODELS:
        model, seconds = _model(name, count, case["model"], seed)
        return [partial(model.pressures, [touch.load]) for touch in touched], seconds
    reference = REFERENCE_SKINS[name](count, seed)
    start = time.perf_counter()
    made = [hold_ball(reference, case["model"], touch.load) for touch in touched]
    return [partial(step_and_sense, simulation) for simulation in made], (time.perf_counter() - start) / len(made)


@lru_cache(maxsize=3)
def _reference_touches(name: str, count: int, contact_mm: float, touches: int, seed: int) -> tuple[ReferenceTouch, ...]:
    """Reference touches, cached for the models of a contact."""
    reference = REFERENCE_SKINS[name](count, seed)
    layer = ElasticLayer()
    blur = reference.blur(layer.depth)
    taxels = len(reference.skin)
    contact = 1e-3 * contact_mm
    places = np.random.default_rng(seed).uniform(-_ASIDE, _ASIDE, (touches, 2))
    return tuple(
        press_ball(reference.dense, *reference.place(*at), contact, taxels=taxels, blur=blur, layer=layer)
        for at in places.tolist()
    )


@lru_cache(maxsize=len(CONTACT_MODELS))
def _model(name: str, count: int, model: str, seed: int) -> tuple[ContactModel, float]:
    """A contact model, cached for the contacts on a skin, and the seconds to build it."""
    skin = REFERENCE_SKINS[name](count, seed).skin
    start = time.perf_counter()
    made = CONTACT_MODELS[model].build(skin, ElasticLayer(), SensorEffects())
    return made, time.perf_counter() - start


@lru_cache(maxsize=1)
def bare_step_ms() -> float:
    """Return the time of a step of our own arm without anything on it, on this machine [ms]."""
    robot = load_robot("arm")
    model = compile_spec(robot_spec(robot), source=robot.source)
    data = mujoco.MjData(model)
    return timed(lambda: mujoco.mj_step(model, data, _STEPS), repeats=25, warm_up=True).ms / _STEPS


def figures(rows: Sequence[Row]) -> list[Figure]:
    """Return each error against the time of a reading, for each skin and contact; taxels increase along a curve."""
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
    "A ball is pressed 1 mm into the middle of a flat square of 100 mm and of a tube with a radius of 36 mm. It is so "
    "large that its contact with a plane has the stated radius. The reference is a Winkler foundation (bed of "
    "springs) sampled at 200,000 points; at the depth of the taxels, 2 mm, it is the Boussinesq stress of those "
    "forces. Models are given force, centre of pressure and the ball. A ball given 1 mm aside represents a collision "
    "hull that does not fit the skin. Shape errors are the forces on the wrong taxels. exact_place_mm is the error of "
    "the centre of pressure from the true forces on the cells: a taxel measures only the sum over its cell, so only a "
    "blur can be better. Foundation and depth are given only the place of the ball; their time is that of a whole step "
    "with its reading. steps are multiples of a bare step of our arm in the same run.",
    cases,
    measure,
    figures,
)
