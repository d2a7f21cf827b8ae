"""What does each effect cost? One effect at a time on our own arm, as a multiple of a bare step."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, get_args

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.scene.effects import EFFECTS, ContactScope, Effects, Integrator, SkinModel
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.model.skin import Skin
from tactile_maps.studies.base.figures import BarChart
from tactile_maps.studies.base.rows import Case, Row, number
from tactile_maps.studies.study.study import Study
from tactile_maps.studies.testbeds.pressed_robot import PressedRobot, pressed_arm
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.plane_vectors import plane_of
from tactile_maps.tactile.poke import Finger, PokePressed

ALL_OFF = Effects(gravity="off", contact="off", joint_limits=False, fingers=False, skin="off")
"""All effects off that can be: the arm and its joints only."""
_PHYSICAL: tuple[SkinModel, ...] = ("foundation", "depth")
"""Models within the physics, which sense bodies there."""
_STEPS_A_TICK = 5
_TICKS_A_ROUND = 10
_WARM_TICKS = 300


@dataclass(frozen=True)
class EffectCase:
    """An effect, with the effects that it requires.

    Attributes:
        effect: Key in ``EFFECTS``; ``none`` for the row with all effects off.
        choice: Value of the effect.
        effects: Effects with it.
        without: The same effects without it.
    """

    effect: str
    choice: str
    effects: Effects
    without: Effects


def effect_cases() -> tuple[EffectCase, ...]:
    """Return every effect in every choice that has a cost, each with the fewest effects that it requires.

    Touch comes from a finger; friction and contact need the probe; effects of the sensor need a skin.
    """
    touched = replace(ALL_OFF, fingers=True)
    pressed = replace(touched, skin="water-fill")
    met = replace(ALL_OFF, contact="probe")
    rubbed = replace(met, friction=True, skin="water-fill")
    rows: list[tuple[str, str, Effects, Effects]] = [
        ("none", "", ALL_OFF, ALL_OFF),
        *(("gravity", word, replace(ALL_OFF, gravity=word), ALL_OFF) for word in ("on", "compensated")),
        ("joint_limits", "on", replace(ALL_OFF, joint_limits=True), ALL_OFF),
        ("joint_friction", "on", replace(ALL_OFF, joint_friction=True), ALL_OFF),
        *(("integrator", w, replace(ALL_OFF, integrator=w), ALL_OFF) for w in get_args(Integrator)),
        ("fingers", "on", touched, ALL_OFF),
        *(("contact", word, replace(ALL_OFF, contact=word), ALL_OFF) for word in get_args(ContactScope)[1:]),
        ("friction", "on", replace(met, friction=True), met),
        *(("skin", w, replace(touched, skin=w), touched) for w in get_args(SkinModel)[1:] if w not in _PHYSICAL),
        *(("skin", w, replace(met, skin=w), met) for w in _PHYSICAL),
        ("shear", "on", replace(rubbed, shear=True), rubbed),
        (
            "time_averaging",
            "on",
            replace(pressed, contact="probe", time_averaging=True),
            replace(pressed, contact="probe"),
        ),
        *((key, "on", _sensing(pressed, key), pressed) for key, entry in EFFECTS.items() if entry.sensor is not None),
    ]
    return tuple(EffectCase(*row) for row in rows)


def _sensing(pressed: Effects, key: str) -> Effects:
    return replace(pressed, sensor=replace(pressed.sensor, **{key: EFFECTS[key].value("on")}))


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every effect in every choice."""
    taxels, rounds = ((1000,), 60) if quick else ((1000, 10_000), 200)
    return [
        {"effect": row.effect, "choice": row.choice, "taxels": count, "rounds": rounds, "seed": seed}
        for count in taxels
        for row in effect_cases()
        if count == taxels[0] or row.effect == "none" or row.effect in ("skin", *_sensor_keys())
    ]


def _sensor_keys() -> tuple[str, ...]:
    return tuple(key for key, entry in EFFECTS.items() if entry.sensor is not None)


def measure(case: Case) -> list[Row]:
    """Return one row: a step with the effect and without, both as multiples of a bare step, timed in turns."""
    row = next(row for row in effect_cases() if (row.effect, row.choice) == (case["effect"], case["choice"]))
    arm = pressed_arm(case["taxels"], case["seed"])
    acts = {
        "bare": _bare_stepper(arm),
        "with": _session_stepper(arm, row.effects),
        "without": _session_stepper(arm, row.without),
    }
    times = _time_in_turns(acts, case["rounds"])
    bare, with_it, without = (times[name] for name in ("bare", "with", "without"))
    return [
        {
            "ratio": float(np.median(with_it / bare)),
            "ratio_p95": float(np.percentile(with_it / bare, 95)),
            "cost": float(np.median((with_it - without) / bare)),
            "step_us": 1e6 * float(np.median(with_it)),
            "bare_us": 1e6 * float(np.median(bare)),
        }
    ]


def _bare_stepper(arm: PressedRobot) -> Callable[[int], None]:
    """Ticks of single MuJoCo steps of the arm with all effects off, held by the same command."""
    model = assemble(arm.robot, arm.skin, ALL_OFF)
    data = mujoco.MjData(model)
    command = arm.command
    model.actuator_gainprm[:, 0] = command.stiffness
    model.actuator_biasprm[:, 1] = -command.stiffness
    model.actuator_biasprm[:, 2] = -command.damping
    data.qpos[:] = arm.robot.home
    data.ctrl[:] = command.posture
    data.qfrc_applied[:] = command.torque

    def run(ticks: int) -> None:
        for _ in range(ticks * _STEPS_A_TICK):
            mujoco.mj_step(model, data)

    return run


def _frames(skin: Skin) -> FloatArray:
    """Return axes t1, t2 and n of each taxel (taxels, 3, 3), of which t1 and t2 have no meaning."""
    return np.stack([np.vstack([plane_of(normal).T, normal]) for normal in skin.normals])


def _session_stepper(arm: PressedRobot, effects: Effects) -> Callable[[int], None]:
    """Return a function that runs ticks like a session: five steps and, with a skin, a reading."""
    simulation = Simulation(
        arm.robot, arm.skin, effects, objects=(arm.probe,), layer=ElasticLayer(), frames=partial(_frames, arm.skin)
    )
    if effects.fingers:
        simulation.apply(PokePressed(1, arm.at, Finger(max_force=10.0)))

    def run(ticks: int) -> None:
        for _ in range(ticks):
            simulation.step(_STEPS_A_TICK, arm.command)
            if effects.skin != "off":
                simulation.sense()

    run(_WARM_TICKS)
    return run


def _time_in_turns(acts: Mapping[str, Callable[[int], None]], rounds: int) -> Mapping[str, Any]:
    """(rounds,) seconds of a step by action; each round runs all actions, so that disturbances affect all of them."""
    seconds = {name: np.zeros(rounds) for name in acts}
    for turn in range(-1, rounds):  # the first warms up and is overwritten
        for name, act in acts.items():
            start = time.perf_counter()
            act(_TICKS_A_ROUND)
            seconds[name][turn] = (time.perf_counter() - start) / (_TICKS_A_ROUND * _STEPS_A_TICK)
    return seconds


def figures(rows: Sequence[Row]) -> list[BarChart]:
    """Return the cost of each effect, sorted, for each number of taxels."""
    return [
        BarChart(
            f"The cost of each effect with {taxels} taxels",
            "more time a step than without it, as a multiple of a bare step",
            {_name(row): number(row["cost"]) for row in rows if row["taxels"] == taxels},
        )
        for taxels in dict.fromkeys(row["taxels"] for row in rows)
    ]


def _name(row: Row) -> str:
    return f"{row['effect']} {row['choice']}".replace("_", " ").removesuffix(" on").strip()


STUDY = Study(
    "effect-cost",
    "What does each effect cost, relative to a bare step of the same arm?",
    "Our own arm, held at home and, where bodies or fingers may touch, pressed with 10 N. Each effect is switched on "
    "alone, with the fewest effects that it requires (friction with contact, effects of the sensor with a skin that is "
    "touched). The ratio is the time of a step with it, in ticks of five and a reading where there is a skin, to that "
    "of a bare mj_step of the same arm with all effects off, in ticks of five as well; the cost is the difference to "
    "the same without it. All three run in turns; medians over the turns.",
    cases,
    measure,
    figures,
)
