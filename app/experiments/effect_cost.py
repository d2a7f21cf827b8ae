"""What does each effect cost? One effect at a time on our own arm, as a multiple of a bare step of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, get_args

import mujoco
import numpy as np

from app.experiments.bars import Bars
from app.experiments.experiment import Experiment
from app.experiments.pressed_arm import PressedArm, pressed_arm
from app.experiments.sweep import Case, Row
from app.scene.effect_table import EFFECTS
from app.scene.effects import Contact, Effects, Integrator, SkinModel
from app.simulation.assemble import assemble
from app.simulation.simulation import Simulation
from app.touch.layer import Layer
from app.touch.poke import Finger, PokePressed

NONE = Effects(gravity="off", contact="off", joint_limits=False, fingers=False, skin="off")
"""Everything off that can be: the arm, its joints and nothing else."""
_PHYSICAL: tuple[SkinModel, ...] = ("foundation", "depth")
"""Models within the physics, which feel bodies there."""
_STEPS_A_TICK, _TICKS_A_ROUND, _WARM_TICKS = 5, 10, 300


@dataclass(frozen=True)
class Priced:
    """One effect on, and what it stands on.

    Attributes:
        effect: Its key in ``effect_table``; ``none`` for the row with all off.
        choice: What it is set to.
        effects: With it.
        without: The same without it.
    """

    effect: str
    choice: str
    effects: Effects
    without: Effects


def priced() -> tuple[Priced, ...]:
    """Every effect in every choice that costs something of its own, each on the least that it needs.

    Touch is felt from a finger; friction and contact need the probe; what the sensor adds needs a skin.
    """
    touched = replace(NONE, fingers=True)
    felt, met = replace(touched, skin="water-fill"), replace(NONE, contact="probe")
    rows: list[tuple[str, str, Effects, Effects]] = [
        ("none", "", NONE, NONE),
        *(("gravity", word, replace(NONE, gravity=word), NONE) for word in ("on", "compensated")),
        ("joint_limits", "on", replace(NONE, joint_limits=True), NONE),
        ("joint_friction", "on", replace(NONE, joint_friction=True), NONE),
        *(("integrator", w, replace(NONE, integrator=w), NONE) for w in get_args(Integrator)),
        ("fingers", "on", touched, NONE),
        *(("contact", word, replace(NONE, contact=word), NONE) for word in get_args(Contact)[1:]),
        ("friction", "on", replace(met, friction=True), met),
        *(("skin", w, replace(touched, skin=w), touched) for w in get_args(SkinModel)[1:] if w not in _PHYSICAL),
        *(("skin", w, replace(met, skin=w), met) for w in _PHYSICAL),
        *((key, "on", _sensing(felt, key), felt) for key, entry in EFFECTS.items() if entry.sensor is not None),
    ]
    return tuple(Priced(*row) for row in rows)


def _sensing(felt: Effects, key: str) -> Effects:
    return replace(felt, sensor=replace(felt.sensor, **{key: EFFECTS[key].value("on")}))


def cases(quick: bool, seed: int) -> list[Case]:
    """Every effect in every choice."""
    taxels, rounds = ((1000,), 60) if quick else ((1000, 10_000), 200)
    return [
        {"effect": row.effect, "choice": row.choice, "taxels": count, "rounds": rounds, "seed": seed}
        for count in taxels
        for row in priced()
        if count == taxels[0] or row.effect == "none" or row.effect in ("skin", *_sensor_keys())
    ]


def _sensor_keys() -> tuple[str, ...]:
    return tuple(key for key, entry in EFFECTS.items() if entry.sensor is not None)


def measure(case: Case) -> list[Row]:
    """One row: a step with the effect and without, both as multiples of a bare step, all three by turns."""
    row = next(row for row in priced() if (row.effect, row.choice) == (case["effect"], case["choice"]))
    arm = pressed_arm(case["taxels"], case["seed"])
    acts = {"bare": _bare(arm), "with": _ticking(arm, row.effects), "without": _ticking(arm, row.without)}
    times = _by_turns(acts, case["rounds"])
    bare, with_it, without = (times[name] for name in ("bare", "with", "without"))
    return [
        {
            "ratio": float(np.median(with_it / bare)),
            "ratio_p95": float(np.percentile(with_it / bare, 95)),
            "price": float(np.median((with_it - without) / bare)),
            "step_us": 1e6 * float(np.median(with_it)),
            "bare_us": 1e6 * float(np.median(bare)),
        }
    ]


def _bare(arm: PressedArm) -> Callable[[int], None]:
    """Ticks of MuJoCo's own steps, each asked for by itself, on the arm with all off, held by the same command."""
    model = assemble(arm.robot, arm.skin, NONE)
    data, command = mujoco.MjData(model), arm.command
    model.actuator_gainprm[:, 0] = command.stiffness
    model.actuator_biasprm[:, 1], model.actuator_biasprm[:, 2] = -command.stiffness, -command.damping
    data.qpos[:], data.ctrl[:], data.qfrc_applied[:] = arm.robot.home, command.posture, command.torque

    def run(ticks: int) -> None:
        for _ in range(ticks * _STEPS_A_TICK):
            mujoco.mj_step(model, data)

    return run


def _ticking(arm: PressedArm, effects: Effects) -> Callable[[int], None]:
    """Ticks of five steps and, where there is a skin, a reading: what a session asks of the physics."""
    simulation = Simulation(arm.robot, arm.skin, effects, objects=(arm.probe,), layer=Layer())
    if effects.fingers:
        simulation.apply(PokePressed(1, arm.at, Finger(max_force=10.0)))

    def run(ticks: int) -> None:
        for _ in range(ticks):
            simulation.step(_STEPS_A_TICK, arm.command)
            if effects.skin != "off":
                simulation.sense()

    run(_WARM_TICKS)
    return run


def _by_turns(acts: Mapping[str, Callable[[int], None]], rounds: int) -> Mapping[str, Any]:
    """(rounds,) seconds of one step by act; a round does each once: they share whatever else the machine does."""
    seconds = {name: np.zeros(rounds) for name in acts}
    for number in range(-1, rounds):  # the first is to warm up
        for name, act in acts.items():
            start = time.perf_counter()
            act(_TICKS_A_ROUND)
            seconds[name][number] = (time.perf_counter() - start) / (_TICKS_A_ROUND * _STEPS_A_TICK)
    return seconds


def figures(rows: Sequence[Row]) -> list[Bars]:
    """The price of each effect, dearest first, for each number of taxels."""
    return [
        Bars(
            f"The price of each effect with {taxels} taxels",
            "more time a step than without it, as a multiple of a bare step",
            {_name(row): float(row["price"] or 0) for row in rows if row["taxels"] == taxels},
        )
        for taxels in dict.fromkeys(row["taxels"] for row in rows)
    ]


def _name(row: Row) -> str:
    return f"{row['effect']} {row['choice']}".replace("_", " ").removesuffix(" on").strip()


EXPERIMENT = Experiment(
    "effect-cost",
    "What does each effect cost, as a multiple of a bare step of the same arm?",
    "Our own arm, held at home and, where bodies or fingers may touch, pressed with 10 N. Each effect is switched on "
    "alone, on the least that it needs (friction on contact, the sensor's effects on a skin that is touched). The "
    "ratio is the time of a step with it, in ticks of five and a reading where there is a skin, to that of a bare "
    "mj_step of the same arm with all off, in ticks of five as well; the price is what is more than the same without "
    "it. All three run by turns; medians over the turns.",
    cases,
    measure,
    figures,
)
