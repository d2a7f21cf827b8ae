"""Interactive editing of a patch: pins are added, dragged and removed, and the map follows within a frame.

``PinFollower`` is a map that follows its pins, with all its faces or, if those are too many for a frame, through the
coarse cage of ``reduced_model``. ``converge`` finishes such a map: converged, without overlap, verified to be
one-to-one, with findings for pins that do not reach their targets. ``PinnedPatch`` combines both, in metres, for an
editor.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.core.errors import Finding, MapError, check_range
from tactile_maps.flattening.bijectivity import BoundaryBarrier, crossings, flipped
from tactile_maps.flattening.chart import Chart, Pin
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.flattening.methods import blended_energy
from tactile_maps.flattening.newton import DescentStopped, Energy, Iterate, OnRound, minimise
from tactile_maps.flattening.pin_descent import Barrier, PinDescent, PinnedEnergy, Springs
from tactile_maps.flattening.reduced_model import CoarseCage, ReducedEnergy, build_coarse_cage
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint

_A_FRAME = 8000
"""Number of faces that can be moved once per frame; smaller patches take more rounds to reach distant targets."""
_MOST_ROUNDS = 6
_STILL = 1e-6
_THERE = 1e-3
"""Distance, in shares of the map's size, below which a pin is visually at its target."""


class PinFollower:
    """A map that follows its pins. Mutable. Planes and goals are in units in which the map's area is about one.

    Args:
        problem: The energy of stretching.
        plane: (k, 2) a map without flips.
        cage: Coarse cage built from that map, or None to move all faces.
    """

    def __init__(self, problem: SymmetricDirichlet, plane: FloatArray, *, cage: CoarseCage | None = None) -> None:
        self.cage = cage
        self._faces = len(problem.faces)
        self._energy: Energy = problem if cage is None else ReducedEnergy(problem, cage.carried)
        self._descent = PinDescent(plane if cage is None else plane[cage.chosen])
        self.pin(np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 2)))
        self._still = True

    @property
    def plane(self) -> FloatArray:
        """(k, 2) the current map, without flips."""
        moved = self._descent.plane
        return moved if self.cage is None else np.asarray(self.cage.carried @ moved)

    @property
    def energy(self) -> float:
        """Energy of stretching and of the springs."""
        return self._pinned.energy(self._descent.plane)

    @property
    def still(self) -> bool:
        """Whether another frame would show nothing new."""
        return self._still

    def pin(self, corners: IntArray, weights: FloatArray, goals: FloatArray) -> None:
        """Replace the pins: (p, 3) vertices of faces, (p, 3) weights in them, (p, 2) targets on the plane."""
        if self.cage is not None:
            corners, weights = self.cage.held(corners, weights)
        self._pinned = PinnedEnergy(self._energy, Springs(corners, weights), goals)
        self._still = False
        self._descent.forget()

    def aim(self, goals: FloatArray) -> None:
        """Set the targets (p, 2) of the pins."""
        self._pinned = self._pinned.towards(goals)
        self._still = False

    def frame(self) -> None:
        """Follow the pins for about the time of a frame; ``energy`` never increases."""
        for _ in range(max(1, min(_MOST_ROUNDS, _A_FRAME // self._faces))):
            gain = self._descent.round(self._pinned)
            self._still = gain <= _STILL * self.energy
            behind = np.linalg.norm(self._pinned.places(self._descent.plane) - self._pinned.goals, axis=1)
            if self._still or behind.max(initial=0.0) <= _THERE:
                return


LAG_TOLERANCE = 1e-3
"""Distance from its target, in shares of the map's size, above which a pin is reported."""
_APPROACH = 120
"""Largest number of rounds towards distant targets before the final descent at full strength."""
_APPROACH_GAIN = 1e-3
_TOLERANCE = 1e-5
"""Relative gain at convergence; with a barrier, ten times that."""


@dataclass(frozen=True, eq=False)
class ConvergenceJob:
    """Input of ``converge``.

    Attributes:
        disk: The patch, of unit area.
        energy: Its energy with pins.
        start: (k, 2) initial map, without flips.
        apart: (k, 2) initial map for the descent with a barrier, without flips and overlap.
        chart: Chart to be replaced.
        unit: Length of a unit of the planes [m].
        name: Name of the patch, for findings and errors.
    """

    disk: Disk
    energy: PinnedEnergy
    start: FloatArray
    apart: FloatArray
    chart: Chart
    unit: float
    name: str


def converge(job: ConvergenceJob, *, on_round: OnRound | None = None) -> Chart:
    """Return the converged chart in the same frame, so that pins remain where they were placed.

    Args:
        job: The patch, its pins and the initial maps.
        on_round: Called after each round; may raise to cancel.

    Raises:
        MapError: No one-to-one map was found.

    Cost: 0.1 s for 10,000 faces; one to three seconds where overlap has to be avoided, up to half a minute at 20,000
    faces where pins were exchanged. A round, after which ``on_round`` is called, takes 0.1 s.
    """
    rounds, notes = _rounds(job, on_round)
    plane = rounds[-1].plane
    if flipped(plane, job.disk.faces).any() or crossings(plane[job.disk.loop]):
        raise MapError("no one-to-one map was found", place=job.name, remedy="Move the pins apart, or remove one")
    behind = np.linalg.norm(job.energy.places(plane) - job.energy.goals, axis=1)
    if (late := behind > LAG_TOLERANCE).any():
        farthest = f"the farthest is {1e3 * job.unit * behind.max():.1f} mm from its target"
        notes.append(Finding("pin-behind", job.name, farthest, int(late.sum())))
    known = [note for note in job.chart.findings if note.kind not in _OF_THE_DESCENT]
    energies = tuple(r.energy for r in rounds)
    seconds = tuple(r.seconds for r in rounds)
    metres = plane * job.unit
    return replace(job.chart, plane=metres, energies=energies, seconds=seconds, findings=(*known, *notes))


_OF_THE_DESCENT = ("pin-behind", "overlap-avoided", "descent-stopped")
"""Kinds of findings that describe a chart's last descent, not its surface."""


def _rounds(job: ConvergenceJob, on_round: OnRound | None) -> tuple[list[Iterate], list[Finding]]:
    begin = time.perf_counter()
    rounds = list[Iterate]()

    def follow(planes: Iterator[FloatArray]) -> list[Finding]:
        try:
            for plane in planes:
                energy = job.disk.energy.energy_at_best_scale(plane)
                rounds.append(Iterate(plane, energy, time.perf_counter() - begin))
                if on_round is not None:
                    on_round(rounds[-1])
        except DescentStopped:
            note = f"after {len(rounds)} rounds, distortion {rounds[-1].energy:.4g} (4 is isometric)"
            return [Finding("descent-stopped", job.name, note)]
        return []

    notes = follow(_descent(job, job.start, lambda energy: energy, _TOLERANCE))
    if not BoundaryBarrier(job.energy, job.disk.loop, rounds[-1].plane).touches(rounds[-1].plane):
        return rounds, notes
    # A barrier preserves a map without overlap, so the descent starts from one.
    planes = _descent(job, job.apart, lambda energy: BoundaryBarrier(energy, job.disk.loop, job.apart), 10 * _TOLERANCE)
    notes = follow(planes)
    avoided = Finding("overlap-avoided", job.name, f"boundary barrier, distortion {rounds[-1].energy:.2f}")
    return rounds, [avoided, *notes]


def _descent(job: ConvergenceJob, start: FloatArray, barrier: Barrier, tolerance: float) -> Iterator[FloatArray]:
    """Yield planes from ``start``: with limited reach while pins are far, then Newton steps at full strength."""
    descent = PinDescent(start, barrier=barrier)
    yield start
    for _ in range(_APPROACH):
        far = np.abs(job.energy.places(descent.plane) - job.energy.goals).max(initial=0.0) > LAG_TOLERANCE
        if not far or descent.round(job.energy) <= _APPROACH_GAIN * job.disk.energy.energy(descent.plane):
            break
        yield descent.plane
    for iterate in minimise(barrier(job.energy), descent.plane, tolerance=tolerance):
        yield iterate.plane


WHOLE = 12_000
"""Number of faces up to which all faces are moved; larger patches use a coarse cage until they converge."""
_FARTHEST_PLACE = 100.0
"""Largest distance of a pin target, in shares of the map's size; no window shows points farther out."""


class PinnedPatch:
    """A patch that follows its pins. Mutable: pins and map change; surface and seams do not.

    All planes and places are in the chart's frame [m], and nothing is rotated or moved back at the end, so that pins
    remain where they were placed. Between calls of ``converge`` the map has no flips, but its border may overlap.

    Args:
        surface: Surface of the patch.
        chart: Its chart, by any method, without flips.
        lengths: 1 to keep lengths, 0 to keep angles, or between.
        pins: Initial pins.
        plane: (k, 2) [m] initial map without flips, by default that of the chart.
        whole: Number of faces above which a coarse cage is used, if one can be built.
        name: The patch's name, for findings and errors.

    Raises:
        MapError: The chart belongs to another surface or has flips, or a pin is invalid; see ``add``.

    Cost: 10 ms for 10,000 faces, and a first frame of 25 ms; 0.1 s for 50,000.
    """

    def __init__(
        self,
        surface: Mesh,
        chart: Chart,
        *,
        lengths: float = 1.0,
        pins: Sequence[Pin] = (),
        whole: int = WHOLE,
        name: str = "patch",
    ) -> None:
        _check(surface, chart, lengths, name)
        self._surface = surface
        self._chart = chart
        self._name = name
        self._whole = whole
        self._unit = float(np.sqrt(surface.area))
        positions = surface.vertices[chart.vertex_of]
        self._disk = Disk(Mesh.of(chart.connectivity, (positions - positions.mean(axis=0)) / self._unit))
        self._objective = blended_energy(self._disk, lengths)
        self._pins: dict[int, Pin] = {}
        self._next = 0
        self._follower = self._following(chart)
        for pin in pins:
            self.add(pin.at, pin.place)

    @property
    def plane(self) -> FloatArray:
        """(k, 2) [m] the current map."""
        return readonly(self._follower.plane * self._unit)

    @property
    def pins(self) -> Mapping[int, Pin]:
        """Pins by number, in the order they were added."""
        return MappingProxyType(self._pins)

    @property
    def lags(self) -> FloatArray:
        """(p,) distance of each pin from its target [m], in the order of ``pins``."""
        corners, weights, goals = self._held()
        there = np.einsum("pc,pcd->pd", weights, self._follower.plane[corners])
        return np.linalg.norm(there - goals, axis=1) * self._unit

    @property
    def lag(self) -> float:
        """Largest distance of a pin from its target [m]."""
        return float(self.lags.max(initial=0.0))

    @property
    def energy(self) -> float:
        """Energy of stretching, for the slider's value, and of the springs; 4 is an isometry with all pins in place."""
        return self._follower.energy

    @property
    def still(self) -> bool:
        """Whether another frame would show nothing new."""
        return self._follower.still

    def add(self, at: SurfacePoint, place: tuple[float, float] | FloatArray | None = None) -> int:
        """Add a pin and return its number.

        Args:
            at: Point on the body; its patch number is ignored.
            place: (x, y) target [m]; by default its current position.

        Raises:
            MapError: The point is not on the body, a pin is already there, or the target is not finite or more than a
                hundred map sizes away.
        """
        weights = np.asarray(at.weights, dtype=np.float64)
        sound = np.isfinite(weights).all() and (weights > -1e-9).all() and abs(weights.sum() - 1) < 1e-6
        if not (0 <= at.face < len(self._chart.faces) and sound):
            raise MapError("a pin is not on the patch", place=self._name, value=f"face {at.face}, weights {at.weights}")
        here = weights @ self._follower.plane[self._chart.faces[at.face]]
        corners, others, _ = self._held()
        places = np.einsum("pc,pcd->pd", others, self._follower.plane[corners])
        if (np.abs(places - here).max(axis=1, initial=0.0) < 1e-9).any():
            raise MapError("a pin is already at this point", place=self._name, remedy="Drag that one")
        target = self._checked(here * self._unit if place is None else place)
        number = self._next
        self._next = self._next + 1
        self._pins[number] = Pin(at, target)
        self._follower.pin(*self._held())
        return number

    def move(self, pin: int, place: tuple[float, float] | FloatArray) -> None:
        """Set the target of pin number ``pin`` to ``place`` (x, y) [m]; the next frames follow.

        Raises:
            MapError: Unknown pin or invalid target, see ``add``. Nothing changes then.
        """
        self._known(pin)
        self._pins[pin] = Pin(self._pins[pin].at, self._checked(place))
        self._follower.aim(self._held()[2])

    def frame(self) -> FloatArray:
        """Follow the pins for about the time of a frame and return the current map (k, 2) [m], without flips.

        While the targets stay, ``energy`` never increases. Pins with conflicting targets stop before the map would
        fold; ``lag`` is their distance.

        Cost: at 10,000 faces 8 ms in the median, 18 ms with a new Hessian.
        """
        self._follower.frame()
        return self.plane

    def converge(self, *, on_round: OnRound | None = None) -> Chart:
        """Return the converged map, with overlap of its border avoided.

        Args:
            on_round: Called after each round; may raise to cancel, and nothing changes then.

        Raises:
            MapError: No one-to-one map was found.

        Cost: see ``converge``; above a few thousand faces use a worker, with ``pins`` and ``plane``.
        """
        start = self._follower.plane
        job = ConvergenceJob(self._disk, self._pinned(), start, self._apart(start), self._chart, self._unit, self._name)
        chart = converge(job, on_round=on_round)
        self._chart = chart
        self._follower = self._following(chart)
        self._follower.pin(*self._held())
        return chart

    def _apart(self, start: FloatArray) -> FloatArray:
        """Return a map without overlap as close to ``start`` as available."""
        for plane in (start, self._chart.plane / self._unit):
            if not BoundaryBarrier(self._objective, self._disk.loop, plane).touches(plane):
                return plane
        return _laid_over(self._disk.start, start)

    def _following(self, start: Chart) -> PinFollower:
        """Return a follower from ``start``; that of a large patch uses a coarse cage."""
        plane = start.plane / self._unit
        cage = None
        if len(start.faces) > self._whole:
            with suppress(MapError):  # moving all faces is slower but as accurate
                cage = build_coarse_cage(self._surface, replace(start, plane=plane), name=self._name)
        return PinFollower(self._objective, plane, cage=cage)

    def _held(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return corners (p, 3), weights (p, 3) and goals (p, 2), in units."""
        pins = self._pins.values()
        corners = self._chart.faces[[pin.at.face for pin in pins]].reshape(-1, 3)
        weights = np.array([pin.at.weights for pin in pins], dtype=np.float64).reshape(-1, 3)
        return corners, weights, np.array([pin.place for pin in pins], dtype=np.float64).reshape(-1, 2) / self._unit

    def _pinned(self) -> PinnedEnergy:
        corners, weights, goals = self._held()
        return PinnedEnergy(self._objective, Springs(corners, weights), goals)

    def _known(self, pin: int) -> None:
        if pin not in self._pins:
            raise MapError("unknown pin number", place=self._name, value=pin)

    def _checked(self, place: tuple[float, float] | FloatArray) -> tuple[float, float]:
        x, y = (float(value) for value in place)
        off = np.abs(np.array([x, y]) - self._chart.plane.mean(axis=0)).max()
        if not off < _FARTHEST_PLACE * self._unit:
            raise MapError("a pin target is too far from the map", place=self._name, value=(x, y))
        return x, y


def _check(surface: Mesh, chart: Chart, lengths: float, name: str) -> None:
    check_range("the share of lengths", lengths, 0, 1, error=MapError, place=name)
    same = chart.faces.shape == surface.faces.shape and chart.vertex_of.max(initial=-1) < len(surface.vertices)
    sized = len(chart.plane) == len(chart.vertex_of)
    if not (same and sized and (chart.vertex_of[chart.faces] == surface.faces).all()):
        raise MapError("the chart belongs to another surface", place=name)
    if flips := int(flipped(chart.plane, chart.faces).sum()):
        raise MapError("the map has flipped triangles", place=name, value=flips, remedy="Flatten the patch first")


def _laid_over(plane: FloatArray, other: FloatArray) -> FloatArray:
    """Return ``plane`` (k, 2) rotated and moved onto ``other`` (k, 2)."""
    flat = plane - plane.mean(axis=0)
    there = other - other.mean(axis=0)
    (a, b), (c, d) = np.einsum("ki,kj->ij", flat, there)
    angle = np.arctan2(b - c, a + d)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray(flat @ turn + other.mean(axis=0))
