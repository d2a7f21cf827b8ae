"""Several controllers on the same stimulus: each from the same start, each with its trace over time and the metrics of
it.

The stimulus comes with its task: what the hand did, and what it asked of the task meanwhile, is the same for all.
Controller and gains are the contender's: where the recording changes them, or a behaviour of the scene would, that is
left out. ``compare_controllers`` runs them, ``controller_metrics`` measures a trace (errors on map and body, force,
contact lost, limits, milliseconds), ``trace_csv`` writes all traces as one table.
"""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tactile_maps.control.behaviours import Behaviour, behaviours_from
from tactile_maps.control.limit_texts import limit_texts
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, SpeedScale
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.arrays import BoolArray, FloatArray, freeze_arrays
from tactile_maps.core.errors import TactileMapsError, UsageError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import (
    BehavioursChanged,
    ControlChanged,
    EffectsChanged,
    MapEdited,
    ReadingChanged,
    SessionInput,
)
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.session import Session
from tactile_maps.studies.base.rows import p95, rms, scaled

TRACE_COLUMNS = ("time", "force", "force_goal", "map_error", "body_error", "joint_speed", "energy", "control_ms")
"""Traces that are numbers, in the order of a file's columns."""


@dataclass(frozen=True, eq=False)
class ControllerTrace:
    """One run, tick by tick.

    An array has NaN at ticks where there was no such thing, numpy's own missing value: it is a gap in a plot, an empty
    cell in ``trace_csv``, and is left out of every figure of ``controller_metrics``.

    Attributes:
        name: Of the contender.
        settings: At the end: controller and gains, and the task as it was last.
        time: (n,) [s].
        force: (n,) of the strongest contact [N], 0 without one.
        force_goal: (n,) wanted [N].
        map_error: (n,) from the contact to where it is wanted, on the map [m].
        body_error: (n,) the same straight across, on the body [m]; of the nearest contact, as it was read.
        joint_speed: (n,) of the joint that is nearest to its limit [``speed_unit``].
        energy: (n,) net energy given to contacts [J].
        control_ms: (n,) wall time of the controller [ms]; no part of what is equal between equal controllers.
        touched: (n,) whether a finger was there to touch.
        limits: (n) what bounded the controller.
        ended: Why it stopped before the time was over; empty where it did not.
        speed_unit: "rad/s", "m/s", or "% of limit" where joints differ, see ``SpeedScale``.
        speed_limit: Largest speed that controllers request, in that unit.
    """

    name: str
    settings: ControlSettings
    time: FloatArray
    force: FloatArray
    force_goal: FloatArray
    map_error: FloatArray
    body_error: FloatArray
    joint_speed: FloatArray
    energy: FloatArray
    control_ms: FloatArray
    touched: BoolArray
    limits: tuple[tuple[Limit, ...], ...]
    ended: str = ""
    speed_unit: str = "rad/s"
    speed_limit: float = MAX_JOINT_SPEED

    def __post_init__(self) -> None:
        freeze_arrays(self, *TRACE_COLUMNS)
        freeze_arrays(self, "touched", dtype=bool)

    def __len__(self) -> int:
        return len(self.time)


class TraceRecorder:
    """Collects a trace. Mutable: ``add`` a tick, then ``trace``.

    Args:
        scale: Of the joint speeds.
    """

    def __init__(self, scale: SpeedScale) -> None:
        self._scale = scale
        self._rows: list[tuple[float | None, ...]] = []
        self._touched: list[bool] = []
        self._limits: list[tuple[Limit, ...]] = []

    def add(self, *, touched: bool, limits: tuple[Limit, ...], **numbers: float | None) -> None:
        """Keep a tick: each of ``TRACE_COLUMNS``, None where there is no such thing."""
        self._rows.append(tuple(numbers[name] for name in TRACE_COLUMNS))
        self._touched.append(touched)
        self._limits.append(limits)

    def trace(self, name: str, settings: ControlSettings, ended: str) -> ControllerTrace:
        """All that was kept, as a value."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, len(TRACE_COLUMNS))
        columns = dict(zip(TRACE_COLUMNS, table.T.copy(), strict=True))
        touched = np.array(self._touched, dtype=np.bool_)
        return ControllerTrace(
            name, settings, **columns, touched=touched, limits=tuple(self._limits), ended=ended,
            speed_unit=self._scale.unit, speed_limit=self._scale.bound,
        )  # fmt: skip


_UNITS = {"time": "s", "force": "N", "force_goal": "N", "map_error": "m", "body_error": "m", "energy": "J"}
"""Of ``TRACE_COLUMNS``, as a file's columns name them."""
_SPEED_UNITS = {"rad/s": "rad_s", "m/s": "m_s", "% of limit": "percent_of_limit"}


@dataclass(frozen=True)
class ControllerMetrics:
    """How well a controller did. None where there was nothing to measure, as the error of a task without a place.

    Attributes:
        map_rms_mm: Root mean square of the error on the map, while in contact [mm].
        map_p95_mm: 95 % of the time it was below [mm].
        body_rms_mm: The same on the body.
        body_p95_mm: The same on the body.
        force_rms_N: Root mean square of the force's departure from its goal, while one was wanted [N].
        force_std_N: How much it departed from its own mean departure: ripple without the lasting error [N].
        force_max_N: Greatest force of a contact [N].
        lost: Share of the time in which a finger was there and, after the first contact, none was felt.
        joint_speed_max: Largest speed of a joint, or the largest share of its limit [``speed_unit``].
        energy_J: Net energy given to contacts at its greatest [J].
        limited: Share of the time in which something bounded the controller.
        limit: What did most often; None where nothing did.
        control_ms: Median wall time of the controller [ms].
        control_p95_ms: 95 % of the ticks took less [ms].
        seconds: How long it ran [s].
        speed_unit: As the trace has it.
    """

    map_rms_mm: float | None
    map_p95_mm: float | None
    body_rms_mm: float | None
    body_p95_mm: float | None
    force_rms_N: float | None
    force_std_N: float | None
    force_max_N: float | None
    lost: float | None
    joint_speed_max: float | None
    energy_J: float | None
    limited: float | None
    limit: LimitKind | None
    control_ms: float | None
    control_p95_ms: float | None
    seconds: float
    speed_unit: str = "rad/s"


def controller_metrics(trace: ControllerTrace) -> ControllerMetrics:
    """Measure a trace; one without a tick has nothing to measure."""
    felt = trace.force > 0
    departure = (trace.force - trace.force_goal)[np.isfinite(trace.force_goal)]
    said = Counter(limit.kind for limits in trace.limits for limit in limits)
    return ControllerMetrics(
        map_rms_mm=scaled(rms(trace.map_error), 1e3),
        map_p95_mm=scaled(p95(trace.map_error), 1e3),
        body_rms_mm=scaled(rms(trace.body_error), 1e3),
        body_p95_mm=scaled(p95(trace.body_error), 1e3),
        force_rms_N=rms(departure),
        force_std_N=float(departure.std()) if departure.size else None,
        force_max_N=_highest(trace.force),
        lost=_share(~felt[trace.touched & np.logical_or.accumulate(felt)]),
        joint_speed_max=_highest(trace.joint_speed),
        energy_J=_highest(trace.energy),
        limited=_share(np.array([bool(limits) for limits in trace.limits], dtype=np.bool_)),
        limit=said.most_common(1)[0][0] if said else None,
        control_ms=float(np.median(trace.control_ms)) if len(trace) else None,
        control_p95_ms=p95(trace.control_ms),
        seconds=float(trace.time[-1]) if len(trace) else 0.0,
        speed_unit=trace.speed_unit,
    )


def trace_csv(traces: Sequence[ControllerTrace]) -> bytes:
    """Return all traces, of one robot, as a table with a row a tick and controller.

    Units are SI, milliseconds, and percent of the limits for joint speeds of unlike joints; limits are in words.
    """
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    units = _UNITS | {"joint_speed": _SPEED_UNITS[traces[0].speed_unit] if traces else "rad_s"}
    columns = [f"{name}_{units[name]}" if name in units else name for name in TRACE_COLUMNS]
    writer.writerow(["name", "controller", *columns, "limits"])
    for trace in traces:
        numbers = [getattr(trace, name) for name in TRACE_COLUMNS]
        for tick, limits in enumerate(trace.limits):
            values = [float(column[tick]) for column in numbers]
            said = ["" if np.isnan(value) else repr(value) for value in values]
            writer.writerow([trace.name, trace.settings.controller, *said, limit_texts(limits)])
    return text.getvalue().encode()


def _highest(values: FloatArray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else None


def _share(which: BoolArray) -> float | None:
    return float(which.mean()) if which.size else None


TASK_FIELDS = ("task", "path_kind", "path", "path_size", "path_speed", "starts", "force_goal")
"""Settings that belong to the stimulus; the others are a contender's own."""
MOST_SECONDS = 600.0
"""Of a comparison."""
_REPORT_TICKS = 20

Inputs = Sequence[tuple[int, SessionInput]]


@dataclass(frozen=True)
class Contender:
    """One of those that are compared.

    Attributes:
        name: For people; no other has it.
        settings: Its controller and gains; and the task, where the stimulus brings none.
    """

    name: str
    settings: ControlSettings


def compare_controllers(
    prepared: PreparedScene,
    contenders: Sequence[Contender],
    *,
    inputs: Inputs | None = None,
    seconds: float = 10.0,
    own_task: bool = False,
    progress: Progress = no_progress,
) -> tuple[ControllerTrace, ...]:
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
    runs = [_ContenderRun(prepared, contender, inputs, own_task=own_task) for contender in contenders]
    count = max(round(seconds / prepared.scene.tick), 1)
    for number in range(count):
        if number % _REPORT_TICKS == 0:
            progress(f"{number * prepared.scene.tick:.1f} of {seconds:.1f}\u202fs", number / count)
        for run in runs:
            run.tick()
    progress("", 1.0)
    return tuple(run.trace for run in runs)


def _check(contenders: Sequence[Contender], seconds: float) -> None:
    names = [contender.name for contender in contenders]
    if not names or len(set(names)) < len(names):
        raise UsageError("controllers are compared by their names", value=names, remedy="Give each a name of its own")
    if not 0 < seconds <= MOST_SECONDS:
        remedy = f"Choose more than 0 and up to {MOST_SECONDS:g} s"
        raise UsageError("controllers cannot be compared for such a time", value=seconds, remedy=remedy)


class _ContenderRun:
    """One contender's session and what is written down of it. Mutable."""

    def __init__(self, prepared: PreparedScene, contender: Contender, inputs: Inputs | None, *, own_task: bool) -> None:
        self._contender = contender
        self._waiting: list[tuple[int, SessionInput]] = []
        settings = contender.settings
        acts = list(inputs or ())
        if inputs is not None:
            kept = ("force_goal",) if own_task else TASK_FIELDS
            settings, self._waiting = _for_contender(acts, settings, kept)
        scene = prepared.scene
        started = {"behaviours": _task_changes_only(behaviours_from(scene.behaviours))} | _session_start(acts)
        if inputs is None:  # only the scene's script may press
            started["effects"] = scene.unattended.effects
        self._session = Session(prepared, scripted=inputs is None, settings=settings, **started)
        self._bodies = _BodyDistance(prepared)
        self._scale = SpeedScale(prepared.robot)
        self._rows = TraceRecorder(self._scale)
        self._ended = ""

    @property
    def trace(self) -> ControllerTrace:
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
        task = frame.task
        settings = self._session.settings
        goal = task.force_goal if task else settings.force_goal if settings.controller == "hold_force" else None
        self._rows.add(
            time=frame.time,
            force=max((region.force for region in frame.regions), default=0.0),
            force_goal=goal,
            map_error=task.error if task else None,
            body_error=self._bodies.nearest(frame, task.target) if task else None,
            joint_speed=self._scale.value(frame.velocity),
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
    start = settings
    waiting = list[tuple[int, SessionInput]]()
    for tick, act in inputs:
        if isinstance(act, ControlChanged):
            if act.by is not None:
                continue  # a behaviour did it, and does it again
            before = settings
            settings = with_fields(settings, act.settings, kept)
            if tick == 0:
                start = settings
            elif settings != before:
                waiting.append((tick, ControlChanged(settings)))
        elif tick > 0:
            tamed = BehavioursChanged(_task_changes_only(act.behaviours)) if isinstance(act, BehavioursChanged) else act
            waiting.append((tick, tamed))
    return start, waiting


def with_fields(settings: ControlSettings, others: ControlSettings, names: Sequence[str]) -> ControlSettings:
    """The settings, with those called ``names`` as ``others`` have them."""
    taken: dict[str, Any] = {name: getattr(others, name) for name in names}
    return replace(settings, **taken)


def _session_start(inputs: Inputs) -> dict[str, Any]:
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
            started["behaviours"] = _task_changes_only(act.behaviours)
        elif isinstance(act, ReadingChanged):
            started["reading"] = act.settings
    return started


def _task_changes_only(behaviours: Sequence[Behaviour]) -> tuple[Behaviour, ...]:
    """The same behaviours, that change nothing but the task."""
    tasks = [
        (behaviour, {name: value for name, value in behaviour.then.items() if name in TASK_FIELDS})
        for behaviour in behaviours
    ]
    return tuple(replace(behaviour, then=then) for behaviour, then in tasks if then)


class _BodyDistance:
    """How far contacts are from a place on the skin, straight across. Keeps the robot's kinematics at one posture."""

    def __init__(self, prepared: PreparedScene) -> None:
        self._skin = prepared.skin
        self._configuration = Configuration(prepared.robot)

    def nearest(self, frame: Frame, target: SurfacePoint | None) -> float | None:
        """From the nearest contact, as it was read, to ``target`` [m]; None without one or the other."""
        if target is None:
            return None
        link = self._skin.link(target)
        point = self._skin.position(target)
        self._configuration.update(frame.posture)
        goal = self._configuration.pose(link).points(point)
        away = [
            float(np.linalg.norm(self._configuration.pose(region.link).points(region.link_position) - goal))
            for region in frame.regions
        ]
        return min(away, default=None)
