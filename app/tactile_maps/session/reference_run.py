"""Reference simulation of a session with finer steps: the error of the displayed values, and the cost of better ones.

The reference receives the same inputs at the same ticks. Its time step is an eighth of the session's, and the
half-space replaces the faster contact models, which omit the blur of the cover. Each simulation is controlled by its
own readings, so the difference is that of the whole loop, not of one step. With the same effects it is exactly zero.
Simplifications of both, such as rigid bodies, cause no difference.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray
from tactile_maps.scene.effects import Effects
from tactile_maps.session.frame import Frame
from tactile_maps.session.input_log import TimedInput
from tactile_maps.session.inputs import EffectsChanged
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings, runtime_settings_at
from tactile_maps.session.session import Session

FINER = 8
"""Number of its time steps in one of the session."""
REFERENCE_MODEL = "half-space"
_BLUR_LEFT_OUT = ("point", "water-fill", "punch")


def reference_effects(effects: Effects) -> Effects:
    """Return the effects of the reference for a session with these effects."""
    model = REFERENCE_MODEL if effects.skin in _BLUR_LEFT_OUT else effects.skin
    return replace(effects, timestep=effects.timestep / FINER, skin=model)


@dataclass(frozen=True)
class ReferenceDifference:
    """Difference between a frame and that of the reference at the same tick.

    Attributes:
        time: Time of both [s].
        place: Largest distance between the centres of a contact and of the nearest contact of the reference on the
            same link, on the body [m]; None without such a pair.
        unmatched: Number of contacts without a partner on their link.
        force: Absolute difference of the total contact forces [N].
        posture: Root mean square over the joints [rad, or m]; 0 without joints.
        wrong_taxels: Force on the wrong taxels as a share of all force that the reference reads; None if it reads none.
        session_ms: Duration of the session's tick [ms].
        reference_ms: Mean duration of the reference's ticks since the last comparison [ms]; None without ticks.
    """

    time: float
    place: float | None
    unmatched: int
    force: float
    posture: float
    wrong_taxels: float | None
    session_ms: float
    reference_ms: float | None


def frame_difference(
    frame: Frame, reference: Frame, areas: FloatArray, reference_ms: float | None
) -> ReferenceDifference:
    """Return the difference of two frames of one tick; ``areas`` (taxels,) [m²]."""
    read = float(reference.pressures @ areas)
    places, unmatched = _match(frame.regions, reference.regions)
    return ReferenceDifference(
        time=frame.time,
        place=max(places, default=None),
        unmatched=unmatched,
        force=abs(_force(frame.regions) - _force(reference.regions)),
        posture=float(np.sqrt(np.mean(np.square(frame.posture - reference.posture)))) if len(frame.posture) else 0.0,
        wrong_taxels=float(np.abs(frame.pressures - reference.pressures) @ areas) / read if read > 0 else None,
        session_ms=frame.timings.total_ms,
        reference_ms=reference_ms,
    )


def _match(ours: Sequence[ContactRegion], theirs: Sequence[ContactRegion]) -> tuple[list[float], int]:
    """Return the distances [m] of pairs on one link, nearest pairs first, and the number of unpaired contacts."""
    pairs = sorted(
        (float(np.linalg.norm(one.link_position - other.link_position)), i, j)
        for i, one in enumerate(ours)
        for j, other in enumerate(theirs)
        if one.link == other.link
    )
    distances = []
    paired = set[tuple[str, int]]()
    for distance, i, j in pairs:
        if paired.isdisjoint(both := {("ours", i), ("theirs", j)}):
            paired |= both
            distances.append(distance)
    return distances, len(ours) + len(theirs) - 2 * len(distances)


def _force(regions: Iterable[ContactRegion]) -> float:
    return sum(region.force for region in regions)


class ReferenceRun:
    """Reference of one session since its start or reset. Mutable; used by one thread.

    Args:
        prepared: The session's scene.
        inputs: Inputs of the session; those at tick 0 are its initial settings.
        effects: Returns the effects of the reference for those of the session.

    Raises:
        TactileMapsError: The scene cannot be simulated with the reference's effects.

    Cost: as a session's; then for our arm 8 to 15 times real time.
    """

    def __init__(
        self,
        prepared: PreparedScene,
        inputs: Iterable[TimedInput],
        *,
        effects: Callable[[Effects], Effects] = reference_effects,
    ) -> None:
        start = runtime_settings_at(RuntimeSettings.of_scene(prepared), inputs, 0)
        self._effects = effects
        self._session = Session(
            prepared,
            scripted=False,
            settings=start.settings,
            map_=start.map,
            effects=effects(start.effects),
            behaviours=start.behaviours,
            reading=start.reading,
        )
        self._waiting: list[TimedInput] = []
        self._seconds = 0.0
        self._ticks = 0

    @property
    def time(self) -> float:
        """Simulated time of the reference [s]."""
        return self._session.frame.time

    def take(self, inputs: Iterable[TimedInput]) -> None:
        """Add the next inputs of the session, in order, each once."""
        self._waiting += [item for item in inputs if item[0] > 0]

    def advance(self, tick: int, seconds: float) -> bool:
        """Advance to the session's ``tick`` for at most ``seconds`` of wall time; return whether it was reached.

        Raises:
            SimulationError: The reference failed.
        """
        begin = time.perf_counter()
        while self._session.frame.tick < tick and time.perf_counter() - begin < seconds:
            while self._waiting and self._waiting[0][0] == self._session.frame.tick + 1:
                given = self._waiting.pop(0)[1]
                if isinstance(given, EffectsChanged):
                    given = replace(given, effects=self._effects(given.effects))
                self._session.submit(given)
            self._session.tick()
            self._ticks += 1
        self._seconds += time.perf_counter() - begin
        return self._session.frame.tick >= tick

    def compare(self, frame: Frame) -> ReferenceDifference:
        """Return the difference of the session's frame at the tick that ``advance`` reached."""
        each = 1e3 * self._seconds / self._ticks if self._ticks else None
        self._seconds = 0.0
        self._ticks = 0
        return frame_difference(frame, self._session.frame, self._session.prepared.skin.areas, each)
