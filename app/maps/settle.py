"""A pinned map brought to rest: converged, kept off itself, proved one-to-one, and told where pins could not get."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from app.arrays import FloatArray
from app.errors import Finding, MapError
from app.maps.bijective import crossings, flipped
from app.maps.border import ApartBorder
from app.maps.chart import Chart
from app.maps.methods.disk import Disk
from app.maps.newton import Iterate, minimise
from app.maps.pin_descent import Barrier, PinDescent
from app.maps.pinned_energy import PinnedEnergy

BEHIND = 1e-3
"""Farther from where it is wanted, in shares of the map's size, a pin is told to be behind."""
_APPROACH = 120
"""At most so many rounds after far pins before the last ones, at full strength."""
_STILL = 1e-3
_TOLERANCE = 1e-5
"""Relative gain at which a map is at rest; kept apart by a barrier, at ten times that."""

Progress = Callable[[Iterate], None]


@dataclass(frozen=True, eq=False)
class Settling:
    """What is to be brought to rest.

    Attributes:
        disk: The patch, of unit area.
        energy: Its energy with pins.
        start: (k, 2) a map of it without flips, where to begin.
        apart: (k, 2) a map that does not lie on itself, where to begin if need be; without flips.
        chart: What is to be replaced.
        unit: Metres for a unit of the planes.
        name: The patch's, for findings and errors.
    """

    disk: Disk
    energy: PinnedEnergy
    start: FloatArray
    apart: FloatArray
    chart: Chart
    unit: float
    name: str


def settle(job: Settling, *, progress: Progress | None = None) -> Chart:
    """The chart at rest, in the same frame, so that pins are where they were put.

    Args:
        job: What to bring to rest.
        progress: Told each round; may raise to cancel.

    Raises:
        MapError: No one-to-one map was found.

    Cost: 0.1 s for 10,000 faces; a second or three where the border has to be kept apart, up to half a minute at 20,000
    where pins were swapped. A round, after which ``progress`` is told, takes 0.1 s.
    """
    rounds, notes = _rounds(job, progress)
    plane = rounds[-1].plane
    if flipped(plane, job.disk.faces).any() or crossings(plane[job.disk.loop]):
        raise MapError("no one-to-one map was found", place=job.name, remedy="Move the pins apart, or remove one")
    behind = np.linalg.norm(job.energy.places(plane) - job.energy.goals, axis=1)
    if (late := behind > BEHIND).any():
        farthest = f"the farthest is {1e3 * job.unit * behind.max():.1f} mm from where it is wanted"
        notes.append(Finding("pin-behind", job.name, farthest, int(late.sum())))
    known = [note for note in job.chart.findings if note.kind not in ("pin-behind", "overlap-avoided")]
    energies, seconds = tuple(r.energy for r in rounds), tuple(r.seconds for r in rounds)
    metres = plane * job.unit
    return replace(job.chart, plane=metres, energies=energies, seconds=seconds, findings=(*known, *notes))


def _rounds(job: Settling, progress: Progress | None) -> tuple[list[Iterate], list[Finding]]:
    begin, rounds = time.perf_counter(), list[Iterate]()

    def follow(planes: Iterator[FloatArray]) -> None:
        for plane in planes:
            energy = job.disk.energy.energy_at_best_scale(plane)
            rounds.append(Iterate(plane, energy, time.perf_counter() - begin, 1.0))
            if progress is not None:
                progress(rounds[-1])

    follow(_descent(job, job.start, lambda energy: energy, _TOLERANCE))
    if not ApartBorder(job.energy, job.disk.loop, rounds[-1].plane).touches(rounds[-1].plane):
        return rounds, []
    # A barrier keeps apart what is apart, so it starts from a map that is.
    follow(_descent(job, job.apart, lambda energy: ApartBorder(energy, job.disk.loop, job.apart), 10 * _TOLERANCE))
    return rounds, [Finding("overlap-avoided", job.name, f"border kept apart, distortion {rounds[-1].energy:.2f}")]


def _descent(job: Settling, start: FloatArray, barrier: Barrier, tolerance: float) -> Iterator[FloatArray]:
    """Planes from ``start``: in reaches while pins are far, then by Newton's steps at full strength."""
    descent = PinDescent(start, barrier=barrier)
    yield start
    for _ in range(_APPROACH):
        far = np.abs(job.energy.places(descent.plane) - job.energy.goals).max(initial=0.0) > BEHIND
        if not far or descent.round(job.energy) <= _STILL * job.disk.energy.energy(descent.plane):
            break
        yield descent.plane
    for iterate in minimise(barrier(job.energy), descent.plane, tolerance=tolerance):
        yield iterate.plane
