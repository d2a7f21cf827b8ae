"""Comparison of controllers with the same stimulus: each from the same start, with its trace and metrics.

The stimulus includes its task: inputs of fingers and changes of the task are the same for all controllers. Controller
and gains are those of the contender: their changes by the recording or by behaviours of the scene are ignored.
``compare_controllers`` runs the contenders, ``controller_metrics`` measures a trace (errors on map and body, force,
lost contact, limits, milliseconds), ``trace_csv`` writes all traces as one table.
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
from tactile_maps.control.motion.limits import Limit, LimitKind, Severity
from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray
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
"""Numeric traces, in the order of the columns of a file."""


@dataclass(frozen=True, eq=False)
class ControllerTrace(ArrayFields):
    """Trace of a run, tick by tick.

    Arrays contain NaN at ticks without a value: a gap in a plot and an empty cell in ``trace_csv``, which
    ``controller_metrics`` ignores.

    Attributes:
        name: Name of the contender.
        settings: Settings at the end: controller and gains, and the last task.
        time: (n,) [s].
        force: (n,) force of the strongest contact [N], 0 without one.
        force_goal: (n,) goal of the force [N].
        map_error: (n,) distance from the contact to its goal, on the map [m].
        body_error: (n,) straight distance on the body [m], for the nearest contact of the reading.
        joint_speed: (n,) speed of the joint nearest to its limit [``speed_unit``].
        energy: (n,) net energy given to contacts [J].
        control_ms: (n,) wall time of the controller [ms]; the only array that differs between equal controllers.
        touched: (n,) whether a finger was present.
        limits: (n) limits of the controller.
        ended: Reason of an early end; empty without one.
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

    def __len__(self) -> int:
        return len(self.time)

    @property
    def unmet(self) -> list[list[LimitKind]]:
        """(n) limits that kept the arm from its goal; adapted gains or speeds do not count."""
        return [[limit.kind for limit in at if limit.kind.severity is not Severity.ADAPTED] for at in self.limits]

    @property
    def limited(self) -> BoolArray:
        """(n,) whether such a limit acted."""
        return np.array([bool(kinds) for kinds in self.unmet], dtype=np.bool_)

    def end_text(self, *, space: str = " ") -> str:
        """Return time and reason of an early end, with this space before the unit; empty without one."""
        when = f"stopped after {self.time[-1]:.3g}{space}s" if len(self) else "stopped in its first tick"
        return f"{when}: {self.ended}" if self.ended else ""


class TraceRecorder:
    """Collects a trace: ``add`` each tick, then ``trace``. Mutable.

    Args:
        scale: Scale of the joint speeds.
    """

    def __init__(self, scale: SpeedScale) -> None:
        self._scale = scale
        self._rows: list[tuple[float | None, ...]] = []
        self._touched: list[bool] = []
        self._limits: list[tuple[Limit, ...]] = []

    def add(self, *, touched: bool, limits: tuple[Limit, ...], **numbers: float | None) -> None:
        """Store a tick: a value for each of ``TRACE_COLUMNS``, None without one."""
        self._rows.append(tuple(numbers[name] for name in TRACE_COLUMNS))
        self._touched.append(touched)
        self._limits.append(limits)

    def trace(self, name: str, settings: ControlSettings, ended: str) -> ControllerTrace:
        """Return the stored ticks as a trace."""
        table = np.array(self._rows, dtype=np.float64).reshape(-1, len(TRACE_COLUMNS))
        columns = dict(zip(TRACE_COLUMNS, table.T.copy(), strict=True))
        touched = np.array(self._touched, dtype=np.bool_)
        return ControllerTrace(
            name,
            settings,
            **columns,
            touched=touched,
            limits=tuple(self._limits),
            ended=ended,
            speed_unit=self._scale.unit,
            speed_limit=self._scale.bound,
        )


_UNITS = {"time": "s", "force": "N", "force_goal": "N", "map_error": "m", "body_error": "m", "energy": "J"}
"""Units of ``TRACE_COLUMNS`` in the column names of a file."""
_SPEED_UNITS = {"rad/s": "rad_s", "m/s": "m_s", "% of limit": "percent_of_limit"}


@dataclass(frozen=True)
class ControllerMetrics:
    """Metrics of a controller. None where there was nothing to measure, for example the error of a task without a goal.

    Attributes:
        map_rms_mm: Root mean square of the error on the map, while in contact [mm].
        map_p95_mm: 95th percentile of that error [mm].
        body_rms_mm: Root mean square of the error on the body [mm].
        body_p95_mm: 95th percentile of that error [mm].
        force_rms_N: Root mean square of the error of the force, while it has a goal [N].
        force_std_N: Standard deviation of that error: ripple without the constant error [N].
        force_max_N: Largest force of a contact [N].
        lost: Share of the time with a finger present, after the first contact, in which no contact was read.
        joint_speed_max: Largest speed of a joint, or largest share of its limit [``speed_unit``].
        energy_J: Maximum net energy given to contacts [J].
        limited: Share of the time in which a limit kept the arm from its goal, see ``ControllerTrace.limited``.
        limit: Most frequent such limit; None without any.
        control_ms: Median wall time of the controller [ms].
        control_p95_ms: 95th percentile of that time [ms].
        seconds: Duration of the run [s].
        speed_unit: Unit of the speeds, as in the trace.
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
    """Return the metrics of a trace."""
    felt = trace.force > 0
    departure = (trace.force - trace.force_goal)[np.isfinite(trace.force_goal)]
    counts = Counter(kind for kinds in trace.unmet for kind in kinds)
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
        limited=_share(trace.limited),
        limit=counts.most_common(1)[0][0] if counts else None,
        control_ms=float(np.median(trace.control_ms)) if len(trace) else None,
        control_p95_ms=p95(trace.control_ms),
        seconds=float(trace.time[-1]) if len(trace) else 0.0,
        speed_unit=trace.speed_unit,
    )


def trace_csv(traces: Sequence[ControllerTrace]) -> bytes:
    """Return all traces of a robot as a table with a row for each tick and controller.

    Units are SI, milliseconds, and percent of the limits for joints with different limits; limits are in words.
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
            cells = ["" if np.isnan(value) else repr(value) for value in values]
            writer.writerow([trace.name, trace.settings.controller, *cells, limit_texts(limits)])
    return text.getvalue().encode()


def _highest(values: FloatArray) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else None


def _share(which: BoolArray) -> float | None:
    return float(which.mean()) if which.size else None


TASK_FIELDS = (
    "task",
    "path_kind",
    "path",
    "path_size",
    "path_speed",
    "starts",
    "force_goal",
    "shear_goal",
    "shear_direction",
)
"""Settings that belong to the stimulus; the others belong to the contender."""
MOST_SECONDS = 600.0
"""Maximum duration of a comparison [s]."""
_REPORT_TICKS = 20

Inputs = Sequence[tuple[int, SessionInput]]


@dataclass(frozen=True)
class Contender:
    """A controller to compare.

    Attributes:
        name: Unique name for people.
        settings: Its controller and gains, and the task if the stimulus has none.
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
    """Run all contenders in turn, tick by tick, so that disturbances of the clock affect all of them equally.

    Args:
        prepared: The scene, with the same seed and effects for all.
        contenders: The controllers. Equal settings give identical traces, except for the milliseconds.
        inputs: (tick, input) as in ``Session.inputs``; None for the script of the scene.
        seconds: Simulated time [s]; the stimulus is truncated, or followed by rest.
        own_task: Use the task of each contender instead of that of ``inputs``; changes of the force goal remain.
        progress: Receives the fraction done, 0 to 1; may raise to cancel.

    Returns:
        One trace each. The trace of a run that stopped early ends there and states why.

    Raises:
        UsageError: There are no contenders, their names are not unique, or the time is out of range.
        TactileMapsError: The scene cannot be simulated, or a setting is out of range.

    Cost: about a tenth of real time for each contender.
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
    """Session and trace of one contender. Mutable."""

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
        """The trace so far."""
        return self._rows.trace(self._contender.name, self._session.settings, self._ended)

    def tick(self) -> None:
        """Simulate one tick, unless the run has ended."""
        if self._ended:
            return
        session = self._session
        while self._waiting and self._waiting[0][0] <= session.frame.tick + 1:
            session.submit(self._waiting.pop(0)[1])
        try:
            frame = session.tick()
        except TactileMapsError as error:  # it diverged, or an input was rejected
            self._ended = str(error)
        else:
            self._write(frame)

    def _write(self, frame: Frame) -> None:
        task = frame.task
        settings = self._session.settings
        goal = task.force_goal if task else settings.force_goal if settings.controller == "hold_force" else None
        self._rows.add(
            time=frame.time,
            force=frame.strongest_force,
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
    """Return the initial settings and the later inputs of a contender.

    Only ``kept`` fields of a change of settings are used; changes without an effect are left out.
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
    """Return the settings with the fields ``names`` of ``others``."""
    changes: dict[str, Any] = {name: getattr(others, name) for name in names}
    return replace(settings, **changes)


def _session_start(inputs: Inputs) -> dict[str, Any]:
    """Initial state of the recorded session, as arguments of another session."""
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
    """The same behaviours, restricted to changes of the task."""
    tasks = [
        (behaviour, {name: value for name, value in behaviour.then.items() if name in TASK_FIELDS})
        for behaviour in behaviours
    ]
    return tuple(replace(behaviour, then=then) for behaviour, then in tasks if then)


class _BodyDistance:
    """Straight distance of contacts from a place on the skin; keeps the robot's kinematics at one posture."""

    def __init__(self, prepared: PreparedScene) -> None:
        self._skin = prepared.skin
        self._configuration = Configuration(prepared.robot)

    def nearest(self, frame: Frame, target: SurfacePoint | None) -> float | None:
        """Return the distance from the nearest contact of a reading to ``target`` [m]; None without one of them."""
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
