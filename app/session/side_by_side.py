"""Several laws on the same stimulus: each from the same start, each with a trace of what became of it.

The stimulus comes with its task: what the hand did, and what it asked of the task meanwhile, is the same for all. Law
and gains are the contender's: where the recording changes them, or a behaviour of the scene would, that is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.control.behaviour import Behaviour, behaviours_from
from app.control.command import ControlChanged, ControlSettings
from app.errors import TactileMapsError, UsageError
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration
from app.session.frame import Frame
from app.session.inputs import BehavioursChanged, EffectsChanged, MapEdited, ReadingChanged, SessionInput
from app.session.law_trace import LawTrace, TraceRows
from app.session.prepare import Prepared
from app.session.session import Session

TASK = ("task", "path_kind", "path", "path_size", "path_speed", "starts", "force_goal")
"""Settings that belong to the stimulus; the others are a contender's own."""
MOST_SECONDS = 600.0
"""Of a comparison."""
_REPORT_TICKS = 20

Inputs = Sequence[tuple[int, SessionInput]]
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Contender:
    """One of those that are compared.

    Attributes:
        name: For people; no other has it.
        settings: Its law and gains; and the task, where the stimulus brings none.
    """

    name: str
    settings: ControlSettings


def _silent(_text: str, _fraction: float) -> None:
    """No progress wanted."""


def side_by_side(
    prepared: Prepared,
    contenders: Sequence[Contender],
    *,
    inputs: Inputs | None = None,
    seconds: float = 10.0,
    own_task: bool = False,
    progress: Progress = _silent,
) -> tuple[LawTrace, ...]:
    """Run all contenders, tick by tick in turn, so that what disturbs the clock disturbs all of them alike.

    Args:
        prepared: The scene; the same seed and effects for all.
        contenders: Two with equal settings give equal traces, bit for bit, but for the milliseconds.
        inputs: (tick, input) as ``Session.inputs`` has them; None for the scene's own script.
        seconds: Simulated; the stimulus is cut off there, or followed by rest.
        own_task: Do the contenders' task instead of the one that came with ``inputs``; changes of the force goal stay.
        progress: Told how far it is, 0 to 1; may raise to cancel.

    Returns:
        A trace each. One that stopped by itself ends where it did, and says why.

    Raises:
        UsageError: Nobody to compare, two of one name, or no such time.
        TactileMapsError: The scene cannot be simulated, or a setting is out of range.

    Cost: that of simulating it as often, about a tenth of real time each.
    """
    _check(contenders, seconds)
    runs = [_Run(prepared, contender, inputs, own_task=own_task) for contender in contenders]
    count = max(round(seconds / prepared.scene.tick), 1)
    for number in range(count):
        if number % _REPORT_TICKS == 0:
            progress(f"{number * prepared.scene.tick:.1f} of {seconds:.1f}\u2009s", number / count)
        for run in runs:
            run.tick()
    progress("", 1.0)
    return tuple(run.trace for run in runs)


def _check(contenders: Sequence[Contender], seconds: float) -> None:
    names = [contender.name for contender in contenders]
    if not names or len(set(names)) < len(names):
        raise UsageError("laws are compared by their names", value=names, remedy="Give each a name of its own")
    if not 0 < seconds <= MOST_SECONDS:
        remedy = f"Choose more than 0 and up to {MOST_SECONDS:g} s"
        raise UsageError("laws cannot be compared for such a time", value=seconds, remedy=remedy)


class _Run:
    """One contender's session and what is written down of it. Mutable."""

    def __init__(self, prepared: Prepared, contender: Contender, inputs: Inputs | None, *, own_task: bool) -> None:
        self._contender = contender
        self._waiting: list[tuple[int, SessionInput]] = []
        settings, acts = contender.settings, list(inputs or ())
        if inputs is not None:
            kept = ("force_goal",) if own_task else TASK
            settings, self._waiting = _for_contender(acts, settings, kept)
        started = {"behaviours": _tame(behaviours_from(prepared.scene.behaviours))} | _started_with(acts)
        self._session = Session(prepared, scripted=inputs is None, settings=settings, **started)
        self._bodies = _BodyDistance(prepared)
        self._rows, self._ended = TraceRows(), ""

    @property
    def trace(self) -> LawTrace:
        """What was written down."""
        return self._rows.trace(self._contender.name, self._session.settings, self._ended)

    def tick(self) -> None:
        """One tick further; nothing once it has stopped."""
        if self._ended:
            return
        session = self._session
        while self._waiting and self._waiting[0][0] <= session.frame.tick + 1:
            session.submit(self._waiting.pop(0)[1])
        try:
            frame = session.tick()
        except TactileMapsError as error:  # it diverged, or an input was refused
            self._ended = str(error)
        else:
            self._write(frame)

    def _write(self, frame: Frame) -> None:
        task, settings = frame.task, self._session.settings
        goal = task.force_goal if task else settings.force_goal if settings.law == "hold_force" else None
        self._rows.add(
            time=frame.time,
            force=max((region.force for region in frame.regions), default=0.0),
            force_goal=goal,
            map_error=task.error if task else None,
            body_error=self._bodies.nearest(frame, task.target) if task else None,
            joint_speed=float(np.abs(frame.velocity).max(initial=0.0)),
            energy=task.energy if task else None,
            control_ms=frame.timings.ms.get("control", 0.0),
            touched=bool(frame.pokes),
            limits=frame.why_limited,
        )


def _for_contender(
    inputs: Inputs, settings: ControlSettings, kept: tuple[str, ...]
) -> tuple[ControlSettings, list[tuple[int, SessionInput]]]:
    """The settings to start with, and the inputs to come, as this contender takes them.

    Of a change of settings only ``kept`` is taken over; one that changes nothing of it is left out.
    """
    start, waiting = settings, list[tuple[int, SessionInput]]()
    for tick, act in inputs:
        if isinstance(act, ControlChanged):
            if act.by:
                continue  # a behaviour did it, and does it again
            before = settings
            settings = with_settings(settings, act.settings, kept)
            if tick == 0:
                start = settings
            elif settings != before:
                waiting.append((tick, ControlChanged(settings)))
        elif tick > 0:
            tamed = BehavioursChanged(_tame(act.behaviours)) if isinstance(act, BehavioursChanged) else act
            waiting.append((tick, tamed))
    return start, waiting


def with_settings(settings: ControlSettings, others: ControlSettings, names: Sequence[str]) -> ControlSettings:
    """The settings, with those called ``names`` as ``others`` have them."""
    taken: dict[str, Any] = {name: getattr(others, name) for name in names}
    return replace(settings, **taken)


def _started_with(inputs: Inputs) -> dict[str, Any]:
    """What was in force at the start of the session that did all this, as arguments of another."""
    started: dict[str, Any] = {}
    for tick, act in inputs:
        if tick > 0:
            break
        if isinstance(act, MapEdited):
            started["map_"] = act.map
        elif isinstance(act, EffectsChanged):
            started["effects"] = act.effects
        elif isinstance(act, BehavioursChanged):
            started["behaviours"] = _tame(act.behaviours)
        elif isinstance(act, ReadingChanged):
            started["reading"] = act.settings
    return started


def _tame(behaviours: Sequence[Behaviour]) -> tuple[Behaviour, ...]:
    """The same behaviours, that change nothing but the task."""
    tasks = [
        (behaviour, {name: value for name, value in behaviour.then.items() if name in TASK}) for behaviour in behaviours
    ]
    return tuple(replace(behaviour, then=then) for behaviour, then in tasks if then)


class _BodyDistance:
    """How far contacts are from a place on the skin, straight across. Keeps the robot's kinematics at one posture."""

    def __init__(self, prepared: Prepared) -> None:
        self._skin, self._configuration = prepared.skin, Configuration(prepared.robot)

    def nearest(self, frame: Frame, target: SurfacePoint | None) -> float | None:
        """From the nearest contact, as it was read, to ``target`` [m]; None without one or the other."""
        if target is None:
            return None
        link, point = self._skin.link(target), self._skin.position(target)
        self._configuration.update(frame.posture)
        goal = self._configuration.pose(link).points(point)
        away = [
            float(np.linalg.norm(self._configuration.pose(region.link).points(region.point) - goal))
            for region in frame.regions
        ]
        return min(away, default=None)
