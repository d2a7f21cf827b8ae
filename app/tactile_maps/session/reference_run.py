"""A session simulated once more beside itself, finer: how far what is shown is off, and what better numbers cost.

The reference gets the same inputs at the same ticks. Its time step is an eighth of the session's, and of the contact
models the half-space stands for the faster ones, which leave out the cover's blur. Each is controlled by its own
readings, so that the difference is that of the whole loop, not of one step; with the same effects it is zero to the
bit. What both leave out alike, such as a body's flexibility, no difference shows.
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
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.session.session import Session

FINER = 8
"""So many of its time steps are one of the session's."""
REFERENCE_MODEL = "half-space"
_BLUR_LEFT_OUT = ("point", "water-fill", "punch")


def reference_effects(effects: Effects) -> Effects:
    """What the reference simulates for a session with these effects."""
    model = REFERENCE_MODEL if effects.skin in _BLUR_LEFT_OUT else effects.skin
    return replace(effects, timestep=effects.timestep / FINER, skin=model)


@dataclass(frozen=True)
class ReferenceDifference:
    """By how much a frame differs from that of the reference at the same tick.

    Attributes:
        time: Of both [s].
        place: Between the centres of a contact and of the nearest of the reference's on the same link, the largest, on
            the body [m]; None where nothing touches in both.
        unmatched: Contacts that the other has none for on that link.
        force: Of all contacts' forces, by amount [N].
        posture: Root mean square over the joints [rad, or m]; 0 without joints.
        wrong_taxels: Force on the wrong taxels, as a share of all force that the reference reads; None where it reads
            none.
        session_ms: What the session's tick took [ms].
        reference_ms: What a tick of the reference took, the mean since the last frame that was compared [ms]; None
            where there was none.
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
    """The difference of two frames of one tick; ``areas`` (taxels,) [m²]."""
    read = float(reference.pressures @ areas)
    places, unmatched = _match(frame.regions, reference.regions)
    return ReferenceDifference(
        time=frame.time,
        place=max(places, default=None),
        unmatched=unmatched,
        force=abs(_force(frame.regions) - _force(reference.regions)),
        posture=_rms(frame.posture - reference.posture),
        wrong_taxels=float(np.abs(frame.pressures - reference.pressures) @ areas) / read if read > 0 else None,
        session_ms=frame.timings.total_ms,
        reference_ms=reference_ms,
    )


def _match(ours: Sequence[ContactRegion], theirs: Sequence[ContactRegion]) -> tuple[list[float], int]:
    """Distances [m] of pairs on one link, the nearest first and each contact once; and how many are left over."""
    pairs = sorted(
        (float(np.linalg.norm(one.link_position - other.link_position)), i, j)
        for i, one in enumerate(ours)
        for j, other in enumerate(theirs)
        if one.link == other.link
    )
    distances = []
    used = set[int]()
    taken = set[int]()
    for distance, i, j in pairs:
        if i not in used and j not in taken:
            used.add(i)
            taken.add(j)
            distances.append(distance)
    return distances, len(ours) + len(theirs) - 2 * len(distances)


def _force(regions: Iterable[ContactRegion]) -> float:
    return sum(region.force for region in regions)


def _rms(off: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.square(off)))) if off.size else 0.0


class ReferenceRun:
    """The reference of one session since its start or reset. Mutable; one thread's own.

    Args:
        prepared: The session's scene.
        inputs: Of the session, those that stand at tick 0: what was in force at its start.
        effects: Of the reference, by those of the session.

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
        start = RuntimeSettings.of_scene(prepared)
        for tick, session_input in inputs:
            start = start.after(session_input) if tick == 0 else start
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
        """How far it has come [s]."""
        return self._session.frame.time

    def take(self, inputs: Iterable[TimedInput]) -> None:
        """The session's next inputs, in its order, each once."""
        self._waiting += [item for item in inputs if item[0] > 0]

    def advance(self, tick: int, seconds: float) -> bool:
        """Go on to the session's ``tick``, but for no longer than ``seconds`` of wall time. Whether it is there.

        Raises:
            SimulationError: The reference itself cannot go on.
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
        """The difference of the session's frame at the tick that was advanced to."""
        each = 1e3 * self._seconds / self._ticks if self._ticks else None
        self._seconds = 0.0
        self._ticks = 0
        return frame_difference(frame, self._session.frame, self._session.prepared.skin.areas, each)
