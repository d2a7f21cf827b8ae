"""Benefit of measured shear in control: pull of a hand that guides the arm, and slip of a lifted block."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from statistics import fmean

import numpy as np

from tactile_maps.control.controller_registry import settings_from
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import prepare
from tactile_maps.session.session import Session
from tactile_maps.studies.base.figures import BarChart
from tactile_maps.studies.base.hypotheses import bootstrap_median
from tactile_maps.studies.base.rows import Case, Cell, Row, number
from tactile_maps.studies.study.study import Study

SEEDS = 5
SHEAR = ("used", "ignored")
"""Use of the measured shear by the controller."""
_LINK = "forearm"
_PRESSED = 2.0
_DRAGGED = 2.0
"""When the hand of ``guided_by_hand`` has pressed, and how long it drags then [s]."""
_CLOSED = 2.5
_LIFTED = 3.0
"""When the fingers of ``carry`` have closed, and how long they lift and hold then [s]."""


@dataclass(frozen=True)
class ShearTask:
    """A shipped scene in which the controller can use shear; the scene has the task's name.

    Attributes:
        levels: Coefficients of friction to try.
        ignore: Returns settings with which the controller ignores shear.
        run: Runs a session and returns the columns of a row.
        figures: Titles and units of the columns that are drawn.
    """

    levels: tuple[float, ...]
    ignore: Callable[[ControlSettings], ControlSettings]
    run: Callable[[Session], dict[str, Cell]]
    figures: Mapping[str, tuple[str, str]]


def _guide(session: Session) -> dict[str, Cell]:
    """Drag the arm by its forearm: the effort is the force of the hand along the skin times the way of the arm."""
    before = _place(session, session.run_for(_PRESSED))
    effort = 0.0
    way = 0.0
    forces = []
    for frame in _frames(session, _DRAGGED):
        after = _place(session, frame)
        step = float(np.linalg.norm(after - before))
        before = after
        way += step
        effort += step * sum(float(np.linalg.norm(_shear(frame, number))) for number in range(len(frame.regions)))
        forces.append(sum(region.force for region in frame.regions))
    return {"pull_n": effort / way, "effort_mj": 1e3 * effort, "way_mm": 1e3 * way, "force_n": fmean(forces)}


def _carry(session: Session) -> dict[str, Cell]:
    """Lift the block: slip is the way by which the fingers rise farther than the block."""
    block = [thing.name for thing in session.prepared.scene.objects].index("block")
    frame = session.run_for(_CLOSED)
    lift = float(frame.posture[0])
    height = float(frame.objects[block, 2, 3])
    slips = []
    forces = []
    for frame in _frames(session, _LIFTED):
        slips.append((float(frame.posture[0]) - lift) - (float(frame.objects[block, 2, 3]) - height))
        forces.append(frame.strongest_force)
    return {"slip_mm": 1e3 * max(slips), "way_mm": 1e3 * (float(frame.posture[0]) - lift), "force_n": fmean(forces)}


def _frames(session: Session, seconds: float) -> Iterator[Frame]:
    return (session.tick() for _ in range(round(seconds / session.prepared.scene.tick)))


def _place(session: Session, frame: Frame) -> FloatArray:
    configuration = Configuration(session.prepared.robot)
    configuration.update(frame.posture)
    return configuration.pose(_LINK).translation


def _shear(frame: Frame, number: int) -> FloatArray:
    shear = frame.regions[number].shear
    return np.zeros(3) if shear is None else np.asarray(shear.force)


TASKS: Mapping[str, ShearTask] = {
    "guided_by_hand": ShearTask(
        (0.3, 0.5, 1.0),
        lambda settings: replace(settings, shear_threshold=inf),
        _guide,
        {
            "pull_n": ("Pull of a hand that guides the arm", "N"),
            "way_mm": ("Way of the arm for 60 mm of the hand", "mm"),
        },
    ),
    "carry": ShearTask(
        (0.5, 0.8, 1.2),
        lambda settings: replace(settings, friction_use=inf),
        _carry,
        {"slip_mm": ("Slip of a lifted block", "mm"), "force_n": ("Force of a finger on a lifted block", "N")},
    ),
}


def cases(quick: bool, seed: int) -> list[Case]:
    """Return every task with every friction, with and without the use of shear; seeds place the taxels."""
    return [
        {"task": name, "friction": friction, "shear": shear, "seed": seed + number}
        for number in range(1 if quick else SEEDS)
        for name, task in TASKS.items()
        for friction in (task.levels[1:2] if quick else task.levels)
        for shear in SHEAR
    ]


def measure(case: Case) -> list[Row]:
    """Return one row: pull and effort, or slip; the way, and the mean normal force."""
    task = TASKS[case["task"]]
    scene = load_scene(case["task"])
    settings = settings_from(scene.control)
    if case["shear"] == "ignored":
        settings = task.ignore(settings)
    rough = replace(
        scene,
        cover=replace(scene.cover, seed=case["seed"]),
        layer=replace(scene.layer, friction=case["friction"]),
        objects=tuple(replace(thing, friction=case["friction"]) for thing in scene.objects),
    )
    return [task.run(Session(prepare(rough), settings=settings))]


def figures(rows: Sequence[Row]) -> list[BarChart]:
    """Return effort, slip and force by friction, with and without the use of shear: medians over seeds."""
    return [
        _chart(rows, name, column, title, unit)
        for name, task in TASKS.items()
        for column, (title, unit) in task.figures.items()
    ]


def _chart(rows: Sequence[Row], task: str, column: str, title: str, unit: str) -> BarChart:
    found: dict[str, list[float]] = {}
    for row in rows:
        amount = number(row.get(column))
        if row["task"] == task and amount is not None:
            found.setdefault(f"friction {row['friction']}, shear {row['shear']}", []).append(amount)
    medians = {name: bootstrap_median(amounts) for name, amounts in found.items()}
    return BarChart(
        title,
        unit,
        {name: median.middle for name, median in medians.items()},
        intervals={name: (median.low, median.high) for name, median in medians.items()},
    )


STUDY = Study(
    "shear-benefit",
    "What does measured shear buy: how hard must a hand pull an arm, and how far does a lifted block slip?",
    "The shipped scenes guided_by_hand and carry with several coefficients of friction, with the controller of the "
    "scene and with the setting that makes it ignore shear (shear_threshold or friction_use without limit); the "
    "physics and the skin are the same. A hand presses the forearm and drags it by 60 mm: its effort is the force "
    "along the skin times the way of the arm, and its pull the effort over the way. Two fingers lift a block of 0.3 "
    "kg: slip is the way by which they rise farther. Seeds place the taxels. No controller uses shear to follow a "
    "path, whose time is therefore the same with one axis and with three.",
    cases,
    measure,
    figures,
)
