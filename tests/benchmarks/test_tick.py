"""Cost of a control tick, its stages, and a tick without effects, as multiples of ``mj_step`` in the same run."""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest

from tactile_maps.contacts.force_estimation.estimate import ESTIMATORS
from tactile_maps.contacts.pipeline import ReadingSettings
from tactile_maps.control.motion.command import CHOICES, ControlSettings
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import PreparedScene, prepare
from tactile_maps.session.session import Session
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.tactile.poke import Finger, PokePressed
from tests.support.touch import arm, hold

CONTROLLERS = CHOICES["controller"]
AT_ONCE = 5
"""Number of bare steps between two ticks; several, because the first one starts with other data in the caches."""
PLACES = (0.50, 0.27, 0.70)
"""Taxels under the fingers, as shares of all taxels."""
STEADY = Finger(max_force=ControlSettings().force_goal)
"""Presses with the force goal, so that no controller loses the contact."""


@cache
def covered(taxels: int) -> PreparedScene:
    scene = load_scene("arm")
    made = prepare(replace(scene, cover=replace(scene.cover, taxels=taxels), stimuli=()))
    assert len(made.skin) >= 0.9 * taxels
    return made


def at_rate(taxels: int, rate: int) -> PreparedScene:
    made = covered(taxels)
    return replace(made, scene=replace(made.scene, tick=1 / rate))


def touched(made: PreparedScene, controller: str, contacts: int, *, task="hold_point", estimator="area-sum") -> Session:
    """Return a session that has been touched for a quarter of a second."""
    settings = ControlSettings(controller=controller, task=task, path_speed=0.02)
    session = Session(made, settings=settings, reading=ReadingSettings(estimator=estimator))
    for finger, share in enumerate(PLACES[:contacts], 1):
        session.submit(PokePressed(finger, made.skin.taxel_point(int(share * len(made.skin))), STEADY))
    for _ in range(round(0.25 / made.scene.tick)):
        session.tick()
    assert session.frame.regions, "it must be measured in contact"
    return session


class Alternation:
    """Measures ticks and bare steps in turn.

    Attributes:
        stages: Duration of each stage in every tick [ms].
        contacts: Number of contacts in every tick.
        bare: Duration of a bare step [ms].
    """

    def __init__(self, session: Session) -> None:
        made = session.prepared
        self._session = session
        self._model = assemble(made.robot, made.skin, made.scene.effects)
        self._data = mujoco.MjData(self._model)
        self.stages: dict[str, list[float]] = defaultdict(list)
        self.contacts: list[int] = []
        self.bare: list[float] = []

    def note(self) -> None:
        """Record the stages of the last tick, and time bare steps."""
        for name, ms in self._session.frame.timings.ms.items():
            known = {"contacts": "regions", "control": "controller", "physics": "physics"}
            self.stages[known.get(name, "skin")].append(ms)
        self.contacts.append(len(self._session.frame.regions))
        start = time.perf_counter()
        mujoco.mj_step(self._model, self._data, AT_ONCE)
        self.bare.append(1e3 * (time.perf_counter() - start) / AT_ONCE)

    def report(self, benchmark) -> None:
        """Report medians as multiples of a bare step, and the control ticks that one core could run in a second."""
        if benchmark.stats is None:
            return
        bare = float(np.median(self.bare))
        control = np.add(self.stages["regions"], self.stages["controller"])
        benchmark.extra_info["contacts"] = f"{np.mean(self.contacts):.1f}"
        benchmark.extra_info["bare step"] = f"{1e3 * bare:.1f} µs"
        for name in ("regions", "controller"):
            benchmark.extra_info[name] = f"{np.median(self.stages[name]) / bare:.0f}"
        middle, high = np.percentile(control, (50, 95)) / bare
        benchmark.extra_info["tick of control"] = f"{middle:.0f} bare steps, p95 {high:.0f}"
        everything = 1e3 * float(np.median(benchmark.stats.stats.data))
        benchmark.extra_info["everything"] = f"{everything / bare:.0f}, {1e3 / everything:.0f} a second"


def measure(benchmark, session: Session, rounds=300) -> None:
    alternation = Alternation(session)
    benchmark.pedantic(session.tick, setup=alternation.note, rounds=rounds, warmup_rounds=20)
    alternation.report(benchmark)


@pytest.mark.parametrize("contacts", [1, 3])
@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("taxels", [1000, 10_000])
def test_tick_in_contact(benchmark, taxels, controller, contacts):
    measure(benchmark, touched(covered(taxels), controller, contacts))


@pytest.mark.parametrize("task", CHOICES["task"])
def test_tick_of_each_task(benchmark, task):
    measure(benchmark, touched(covered(1000), "hybrid", 1, task=task))


@pytest.mark.parametrize("estimator", ESTIMATORS)
@pytest.mark.parametrize("taxels", [1000, 10_000])
def test_tick_with_each_force_estimator(benchmark, taxels, estimator):
    """Measure a tick; ``regions`` includes the force estimator."""
    measure(benchmark, touched(covered(taxels), "hybrid", 1, estimator=estimator), rounds=100)


@pytest.mark.parametrize("taxels", [1000, 10_000])
def test_tick_with_an_image_256_pixels_wide(benchmark, taxels):
    """Measure a tick that also computes the image."""
    session = touched(covered(taxels), "hybrid", 1)
    alternation = Alternation(session)
    image = TactileImage(session.map, width=256)
    drawn: list[float] = []

    def tick_and_draw() -> None:
        frame = session.tick()
        start = time.perf_counter()
        image.render(frame.pressures)
        drawn.append(1e3 * (time.perf_counter() - start))

    benchmark.pedantic(tick_and_draw, setup=alternation.note, rounds=300, warmup_rounds=20)
    benchmark.extra_info["image"] = f"{np.median(drawn) / np.median(alternation.bare):.0f}"
    alternation.report(benchmark)


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize(("taxels", "rate"), [(1000, 1000), (10_000, 200)])
def test_tick_rate_sustained_by_one_core(benchmark, taxels, rate, controller):
    """Measure the speed relative to real time for a second in contact, with physics and skin, at a requested rate.

    The speed is in CPU time and does not depend on other load; late ticks are counted by wall time.
    """
    session = touched(at_rate(taxels, rate), controller, 1)
    ticks: list[float] = []
    busy: list[float] = []

    def second() -> None:
        begin = time.process_time()
        for _ in range(rate):
            start = time.perf_counter()
            session.tick()
            ticks.append(time.perf_counter() - start)
        busy.append(time.process_time() - begin)

    benchmark.pedantic(second, rounds=3, warmup_rounds=1)
    assert session.frame.regions, "it must be measured in contact"
    took = float(np.median(busy))
    benchmark.extra_info["real time"] = f"{1 / took:.1f} times"
    benchmark.extra_info["ticks a second"] = f"{rate / took:.0f}"
    benchmark.extra_info["late"] = f"{100 * np.mean(np.array(ticks) > 1 / rate):.2f} % of {rate} Hz ticks"


OFF = Effects(gravity="off", contact="off", joint_limits=False, fingers=False, skin="off")
STEPS = 5


def test_tick_with_all_effects_off(benchmark):
    prepared = arm()
    simulation = Simulation(prepared.robot, prepared.skin, OFF)
    command = hold(prepared.robot, 3.0, 0.5)
    simulation.step(STEPS, command)
    benchmark.pedantic(simulation.step, args=(STEPS, command), rounds=2000, warmup_rounds=100)
    assert np.isfinite(simulation.posture).all()
    if benchmark.stats is not None:
        ours, bare = _side_by_side(simulation, command)
        benchmark.extra_info["tick of 5 steps"] = f"{1e6 * ours:.2f} µs"
        benchmark.extra_info["5 bare mj_step"] = f"{1e6 * bare:.2f} µs"
        benchmark.extra_info["ratio"] = f"{ours / bare:.3f}"


def _side_by_side(simulation: Simulation, command) -> tuple[float, float]:
    """Return the median times [s] of a tick and of as many bare steps, measured in turn, so that load affects both."""
    model = simulation._model
    data = mujoco.MjData(simulation._model)
    took = ([], [])
    data.qpos[:] = simulation.posture
    data.ctrl[:] = command.posture
    for _ in range(4000):
        start = time.perf_counter()
        simulation.step(STEPS, command)
        between = time.perf_counter()
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
        end = time.perf_counter()
        took[0].append(between - start)
        took[1].append(end - between)
    return float(np.median(took[0])), float(np.median(took[1]))
