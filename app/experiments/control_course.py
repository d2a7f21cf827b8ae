"""One course: a controller leads a contact along a path for a round, and what truly happens is told from the truth.

The controller knows the skin by a calibration, a map, a sensor and an estimator; what counts is where the object really
touches the skin that is there, and how hard. Both come from the simulation's own contacts, not from any reading.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.arrays import FloatArray, readonly
from app.control.command import ControlChanged, ControlSettings
from app.control.map_path import draw_path, path_about
from app.errors import SimulationError
from app.experiments.control_setup import ControlSetup
from app.experiments.true_touch import TrueTouch
from app.session.frame import Frame
from app.session.session import Session

SETTLING = 1.0
"""How long the contact is held at the start of the path before it sets out [s]."""
STOPPED = "stopped: "
"""How the supervisor begins to say why."""
_SENSED = ("contacts", "control")
"""Stages of a tick that a controller's computer has to do."""


@dataclass(frozen=True, eq=False)
class Course:
    """What happened once the contact had set out, tick by tick. What cannot be known is nan.

    Attributes:
        tick: [s].
        body_error: (k,) from where the object truly touches to where the path wants it, on the body [m]; nan where
            nothing touches.
        map_error: (k,) the same as the controller sees it, on its map [m].
        force: (k,) that truly presses the skin [N].
        speed: (k,) of the fastest joint [rad/s, or m/s].
        energy: (k,) net energy given to contacts [J].
        finished: How long a round took [s]; nan where it was not finished.
        control_ms: What reading and control of one tick take, the median [ms].
        control_p95_ms: 95 % of the ticks take less [ms].
        why_limited: All that was said to limit the controller, in the order in which it came.
        stopped: Why it ended before its time: the supervisor stopped the arm, or the physics diverged; empty when not.
    """

    tick: float
    body_error: FloatArray
    map_error: FloatArray
    force: FloatArray
    speed: FloatArray
    energy: FloatArray
    finished: float
    control_ms: float
    control_p95_ms: float
    why_limited: tuple[str, ...] = ()
    stopped: str = ""

    def __post_init__(self) -> None:
        for name in ("body_error", "map_error", "force", "speed", "energy"):
            object.__setattr__(self, name, readonly(getattr(self, name)))

    @property
    def error_p95(self) -> float:
        """95 % of the errors on the body are below [m]; nan without contact."""
        return _p95(self.body_error)

    @property
    def error_rms(self) -> float:
        """Root mean square of the error on the body [m]; nan without contact."""
        known = self.body_error[np.isfinite(self.body_error)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")

    @property
    def lost(self) -> float:
        """Share of the time without contact."""
        return float(np.isnan(self.body_error).mean()) if len(self.body_error) else 1.0

    @property
    def energy_minimum(self) -> float:
        """Of what a passivity observer at the contact counts [J]: below zero by what the arm gave."""
        return float(min(-self.energy.max(initial=0.0), 0.0))

    def in_band(self, goal: float, band: float) -> float:
        """Share of the time with a force within ``band`` of ``goal`` [N]."""
        return float((np.abs(self.force - goal) <= band).mean()) if len(self.force) else 0.0

    def force_p95(self, goal: float) -> float:
        """95 % of the force's errors are below [N]."""
        return _p95(np.abs(self.force - goal))


def run_course(
    setup: ControlSetup, settings: ControlSettings, seconds: float, *, settling: float = SETTLING, rounds: float = 1.0
) -> Course:
    """Let the contact settle at the start of the path, then lead it along until the rounds are done.

    Args:
        setup: The truth, and what is believed of it.
        settings: Of the controller; of another task than a path nothing is finished, and it takes all its time.
        seconds: At most, after settling.
        settling: Before the path sets out [s].
        rounds: How often to go along the path; a round of an open one ends at its other end.

    Raises:
        TactileMapsError: The setup cannot be simulated.
    """
    session = setup.session(replace(settings, path_speed=0.0))
    watch = _Watch(session, setup)
    ticks = round(settling / session.prepared.scene.tick)
    try:
        for _ in range(ticks):
            session.tick()
        session.submit(ControlChanged(settings))
        watch.look(settings, seconds, rounds)
    except SimulationError as error:
        watch.stopped = str(error)
    return watch.course()


class _Watch:
    """Looks on. Mutable: rows tick by tick."""

    def __init__(self, session: Session, setup: ControlSetup) -> None:
        self._session, self._tick = session, session.prepared.scene.tick
        self._truth = TrueTouch(setup.prepared.robot, setup.prepared.skin, setup.map)
        self._rows: list[tuple[float, float, float, float, float, float]] = []
        self._why: dict[str, None] = {}
        self._finished, self.stopped = float("nan"), ""

    def look(self, settings: ControlSettings, seconds: float, rounds: float) -> None:
        """Tick until the rounds are done or the time is over."""
        done, last = 0.0, self._way
        step = settings.path_speed * self._tick
        for _ in range(round(seconds / self._tick)):
            frame = self._session.tick()
            self._see(frame)
            self.stopped = next((why for why in frame.why_limited if why.startswith(STOPPED)), "")
            if self.stopped:
                return
            # At the end of a closed path the way begins anew.
            done, last = done + min(abs(self._way - last), step), self._way
            if step and done >= rounds * self._length(settings) - step / 2:
                self._finished = len(self._rows) * self._tick
                return

    @property
    def _way(self) -> float:
        task = self._session.frame.task
        return task.way if task is not None else 0.0

    def _length(self, settings: ControlSettings) -> float:
        """Of the path [m]; endless until it is laid."""
        task = self._session.frame.task
        if settings.task != "follow_path":
            return float("inf")
        if len(settings.path) > 1:
            return draw_path(settings.path_kind, settings.path).length
        if task is None or task.laid_at is None:
            return float("inf")
        return path_about(settings.path_kind, np.array(task.laid_at), settings.path_size).length

    def _see(self, frame: Frame) -> None:
        task, force = frame.task, self._session.pressing
        body = on_map = float("nan")
        if task is not None and task.target is not None and force > 0:
            body = self._truth.error(task.target, frame.objects[0, :3, 3], frame.posture)
            on_map = float("nan") if task.error is None else task.error
        ms = sum(frame.timings.ms.get(stage, 0.0) for stage in _SENSED)
        fastest = float(np.abs(frame.velocity).max(initial=0.0))
        self._rows.append((body, on_map, force, fastest, task.energy if task else 0.0, ms))
        self._why.update(dict.fromkeys(frame.why_limited))

    def course(self) -> Course:
        """All of it."""
        body, on_map, force, speed, energy, ms = np.array(self._rows, dtype=np.float64).reshape(-1, 6).T
        control = float(np.median(ms)) if len(ms) else float("nan")
        why = tuple(self._why)
        late = _p95(ms)
        return Course(self._tick, body, on_map, force, speed, energy, self._finished, control, late, why, self.stopped)


def _p95(values: FloatArray) -> float:
    """The 95th percentile of those that are numbers; nan where there is none."""
    known = values[np.isfinite(values)]
    return float(np.percentile(known, 95)) if len(known) else float("nan")
