"""Simulates a recording again from its inputs and compares every state, bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import RecordingError, SimulationError, TactileMapsError
from tactile_maps.core.progress import Progress, no_progress
from tactile_maps.core.timing import Timings
from tactile_maps.recording.encoding.frame_codec import encode_frame
from tactile_maps.recording.file.damage import DamageKind
from tactile_maps.recording.machine import machine_facts
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import versions
from tactile_maps.session.frame import Frame
from tactile_maps.session.session import Session


@dataclass(frozen=True)
class Verification:
    """Result of a verification.

    Attributes:
        frames: Number of compared frames.
        identical: Whether all of them are equal, bit for bit, in everything but the measured computing times: state,
            pressures, contacts, fingers, commands and their limits, estimates, task; and a session that stopped by
            itself stopped again at the same tick, by an error of the same type with the same place and value. None if
            no frame could be compared.
        max_difference: Largest difference of any posture, velocity, object pose, finger force or estimated force (SI)
            or pressure (kPa); inf if one of the two runs stopped. It may be 0 if only something else differs.
        first_difference: Tick of the first difference; None if identical.
        other_versions: Versions that differ from the recorded ones; results are only guaranteed equal without any.
        stopped: Why the session stopped again, as recorded; None if it did not stop.
        not_compared: Number of frames that were not compared because inputs before them are missing.
        differing: Quantity with the largest difference and its unit, like "pressures [kPa]"; empty if there is none.
        other_machine: Processor and BLAS of the recording, and of this machine, if they differ: they are then the
            likely cause of a small difference. Empty if they are equal or the recording does not state them.
    """

    frames: int
    identical: bool | None
    max_difference: float
    first_difference: int | None
    other_versions: tuple[str, ...]
    stopped: str | None = None
    not_compared: int = 0
    differing: str = ""
    other_machine: tuple[str, ...] = ()


def verify(player: RecordingPlayer, *, progress: Progress = no_progress) -> Verification:
    """Simulate the recorded inputs from the session's start and compare with the recorded frames.

    Args:
        player: The recording.
        progress: Receives a description and the progress, 0 to 1; may raise to cancel.

    Raises:
        RecordingError: The readings were measured, so there is nothing to simulate.
        TactileMapsError: A frame is damaged, or an input is rejected.

    Cost: the time of the simulation, about a tenth of real time.
    """
    if player.measured is not None:
        problem = "measured readings cannot be simulated again"
        raise RecordingError(problem, file=player.path, value=player.measured)
    again = Resimulation(player)
    largest = 0.0
    differing = ""
    first = None
    compared = 0
    sure = _last_sure_tick(player)
    for number in range(len(player)):
        recorded = player.frame(number)
        if sure is not None and recorded.tick > sure:
            break
        frame = again.frame(recorded.tick)
        difference, quantity = _difference(frame, recorded)
        compared += 1
        if difference > largest:
            largest = difference
            differing = quantity
        if first is None and (difference != 0.0 or _content(frame) != _content(recorded)):
            first = min(recorded.tick, frame.tick + 1)  # a run that stopped is at an earlier tick
        if number % 200 == 0:
            progress("Simulating again", number / len(player))
    stopped, tick = again.ending() if sure is None else (None, None)
    if tick is not None:
        largest = float("inf")
        differing = ""
        first = tick if first is None else first
    missing = len(player) - compared
    identical = None if compared == 0 else first is None
    return Verification(
        frames=compared,
        identical=identical,
        max_difference=largest,
        first_difference=first,
        other_versions=_changed_versions(player),
        stopped=stopped,
        not_compared=missing,
        differing=differing,
        other_machine=_other_machine(player),
    )


def _last_sure_tick(player: RecordingPlayer) -> int | None:
    """Return the tick up to which the recorded inputs are complete; None if all are."""
    starts = [damage.first or 0 for damage in player.damage if damage.kind == DamageKind.INPUTS_MISSING]
    return min(starts, default=None)


class Resimulation:
    """A new session that receives the recorded inputs at their ticks. Mutable.

    Args:
        player: A recording with simulated readings.

    Attributes:
        session: The session, as far as it was simulated.
    """

    def __init__(self, player: RecordingPlayer) -> None:
        start = player.runtime_settings_at(0)
        self.session = Session(
            player.prepared,
            scripted=False,
            settings=start.settings,
            map_=start.map,
            effects=start.effects,
            behaviours=start.behaviours,
            reading=start.reading,
        )
        self._waiting = [item for item in player.inputs if item[0] > 0]
        self._recorded = player.failure

    def frame(self, tick: int) -> Frame:
        """Return the frame of ``tick``; an earlier one if the session stops before."""
        session = self.session
        while session.frame.tick < tick and session.failure is None:
            while self._waiting and self._waiting[0][0] == session.frame.tick + 1:
                session.submit(self._waiting.pop(0)[1])
            try:
                session.tick()
            except SimulationError:
                if session.failure is None:
                    raise  # an input was rejected, unlike in the recording
        return session.frame

    def ending(self) -> tuple[str | None, int | None]:
        """Return why the session stopped, if as recorded, and the tick at which its end differs from the recording."""
        if self._recorded is not None:
            self.frame(self._recorded[0])
        failure = self.session.failure
        if self._recorded is None:
            return None, None if failure is None else failure.tick
        tick, error = self._recorded
        if failure is None:
            return None, tick
        if (failure.tick, _identity(failure.error)) != (tick, _identity(error)):
            return None, min(tick, failure.tick)
        return failure.problem, None


def _identity(error: TactileMapsError) -> tuple[object, ...]:
    """Return what identifies an error: type, place and value, but not the wording."""
    return type(error), error.place, None if error.value is None else str(error.value)


def _changed_versions(player: RecordingPlayer) -> tuple[str, ...]:
    now = versions()
    return tuple(
        f"{key} {value} (now {now[key]})" for key, value in player.versions.items() if key in now and now[key] != value
    )


def _other_machine(player: RecordingPlayer) -> tuple[str, ...]:
    now = machine_facts()
    recorded = {name: player.versions.get(name, "unknown") for name in now}
    if recorded == now or set(recorded.values()) == {"unknown"}:
        return ()
    return f"recorded on {', '.join(recorded.values())}", f"now on {', '.join(now.values())}"


def _content(frame: Frame) -> bytes:
    """Return the exact content of a frame without the measured computing times. Cost: 40 µs.

    The number of touched taxels is left out: recordings of earlier versions do not store it, and the area depends on
    the same taxels.
    """
    regions = tuple(replace(region, touched=None) for region in frame.regions)
    return encode_frame(replace(frame, timings=Timings(), regions=regions))


def _quantities(frame: Frame) -> dict[str, FloatArray]:
    """Return the compared numbers of a frame by quantity and unit."""
    estimates = [estimate for _, estimate in sorted(frame.estimates.items())]
    return {
        "joint positions [rad, m for slides]": frame.posture,
        "joint velocities [rad/s, m/s for slides]": frame.velocity,
        "pressures [kPa]": 1e-3 * frame.pressures,
        "object poses [m]": frame.objects,
        "estimated forces [N]": np.array([force for one in estimates for force in (one.force, *one.forces)]),
        "finger forces [N]": np.array([poke.force for poke in frame.pokes]),
    }


def _difference(one: Frame, other: Frame) -> tuple[float, str]:
    """Return the largest difference and its quantity; inf if shapes differ or only one of two numbers is NaN."""
    numbers = _quantities(one)
    others = _quantities(other)
    if one.tick != other.tick or any(numbers[name].shape != others[name].shape for name in numbers):
        return float("inf"), ""
    found = [(float(np.abs(a - others[name]).max()), name) for name, a in numbers.items() if a.size]
    finite = [(worst if np.isfinite(worst) else float("inf"), name) for worst, name in found]
    return max(finite, key=lambda one: one[0], default=(0.0, ""))
