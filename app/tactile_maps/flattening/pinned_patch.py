"""A patch that is edited interactively: pins are put in, dragged and taken out, and the map follows within a frame.

``PinFollower`` is a map that follows its pins: with all its faces, or, where those are too many for a frame, carried by
the coarse cage of ``reduced_model``. ``converge`` finishes such a map: converged, kept off itself, proved one-to-one,
and told where pins could not get. ``PinnedPatch`` is both together, in metres, as an editor uses it.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray, readonly
from tactile_maps.core.errors import Finding, MapError
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
"""Faces for which there is time for one round a frame; smaller patches take more rounds to catch up with far pins."""
_MOST_ROUNDS = 6
_STILL = 1e-6
_THERE = 1e-3
"""Nearer, in shares of the map's size, a pin is where it is wanted to the eye."""


class PinFollower:
    """Mutable: the map and its pins. Planes and goals are in units in which the map's area is about one.

    Args:
        problem: The energy of stretching.
        plane: (k, 2) a map without flips.
        cage: A coarse cage made from that map, to follow by; None to follow with all faces.
    """

    def __init__(self, problem: SymmetricDirichlet, plane: FloatArray, *, cage: CoarseCage | None = None) -> None:
        self._cage = cage
        self._faces = len(problem.faces)
        self._energy: Energy = problem if cage is None else ReducedEnergy(problem, cage.carried)
        self._descent = PinDescent(plane if cage is None else plane[cage.chosen])
        self.pin(np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 2)))
        self._still = True

    @property
    def plane(self) -> FloatArray:
        """(k, 2) the present map, without flips."""
        moved = self._descent.plane
        return moved if self._cage is None else np.asarray(self._cage.carried @ moved)

    @property
    def energy(self) -> float:
        """Of stretching and of the springs."""
        return self._pinned.energy(self._descent.plane)

    @property
    def still(self) -> bool:
        """Whether another frame would show nothing new."""
        return self._still

    def pin(self, corners: IntArray, weights: FloatArray, goals: FloatArray) -> None:
        """Be held there from now on: (p, 3) vertices of faces, (p, 3) weights in them, (p, 2) where on the plane."""
        if self._cage is not None:
            corners, weights = self._cage.held(corners, weights)
        self._pinned = PinnedEnergy(self._energy, Springs(corners, weights), goals)
        self._still = False
        self._descent.forget()

    def aim(self, goals: FloatArray) -> None:
        """Want the pins at ``goals`` (p, 2)."""
        self._pinned = self._pinned.towards(goals)
        self._still = False

    def frame(self) -> None:
        """Follow the pins for about a frame's time; ``energy`` never rises."""
        for _ in range(max(1, min(_MOST_ROUNDS, _A_FRAME // self._faces))):
            gain = self._descent.round(self._pinned)
            self._still = gain <= _STILL * self.energy
            behind = np.linalg.norm(self._pinned.places(self._descent.plane) - self._pinned.goals, axis=1)
            if self._still or behind.max(initial=0.0) <= _THERE:
                return


LAG_TOLERANCE = 1e-3
"""Farther from where it is wanted, in shares of the map's size, a pin is told to be behind."""
_APPROACH = 120
"""At most so many rounds after far pins before the last ones, at full strength."""
_APPROACH_GAIN = 1e-3
_TOLERANCE = 1e-5
"""Relative gain at which a map is at rest; kept apart by a barrier, at ten times that."""


@dataclass(frozen=True, eq=False)
class ConvergenceJob:
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


def converge(job: ConvergenceJob, *, on_round: OnRound | None = None) -> Chart:
    """The chart at rest, in the same frame, so that pins are where they were put.

    Args:
        job: What to bring to rest.
        on_round: Told each round; may raise to cancel.

    Raises:
        MapError: No one-to-one map was found.

    Cost: 0.1 s for 10,000 faces; a second or three where the border has to be kept apart, up to half a minute at 20,000
    where pins were swapped. A round, after which ``on_round`` is told, takes 0.1 s.
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
"""Kinds of findings that are of a chart's last descent, not of its surface."""


def _rounds(job: ConvergenceJob, on_round: OnRound | None) -> tuple[list[Iterate], list[Finding]]:
    begin = time.perf_counter()
    rounds = list[Iterate]()

    def follow(planes: Iterator[FloatArray]) -> list[Finding]:
        try:
            for plane in planes:
                energy = job.disk.energy.energy_at_best_scale(plane)
                rounds.append(Iterate(plane, energy, time.perf_counter() - begin, 1.0))
                if on_round is not None:
                    on_round(rounds[-1])
        except DescentStopped:
            note = f"after {len(rounds)} rounds, distortion {rounds[-1].energy:.4g} (4 is isometric)"
            return [Finding("descent-stopped", job.name, note)]
        return []

    notes = follow(_descent(job, job.start, lambda energy: energy, _TOLERANCE))
    if not BoundaryBarrier(job.energy, job.disk.loop, rounds[-1].plane).touches(rounds[-1].plane):
        return rounds, notes
    # A barrier keeps apart what is apart, so it starts from a map that is.
    planes = _descent(job, job.apart, lambda energy: BoundaryBarrier(energy, job.disk.loop, job.apart), 10 * _TOLERANCE)
    notes = follow(planes)
    avoided = Finding("overlap-avoided", job.name, f"boundary barrier, distortion {rounds[-1].energy:.2f}")
    return rounds, [avoided, *notes]


def _descent(job: ConvergenceJob, start: FloatArray, barrier: Barrier, tolerance: float) -> Iterator[FloatArray]:
    """Planes from ``start``: in reaches while pins are far, then by Newton's steps at full strength."""
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
"""Faces up to which a patch follows with all of them; larger ones by a coarse cage, and in full when settled."""
_FARTHEST_PLACE = 100.0
"""In shares of the map's size: farther out no window shows a place."""


class PinnedPatch:
    """One patch that follows its pins. Mutable: the pins and the present map change; surface and seams stay.

    All planes and places are in the chart's own frame [m]; nothing is turned or moved back at the end, so that pins
    stay where they were put. Between ``converge``s the map is without flips, but its border may come to lie on itself.

    Args:
        surface: The patch's.
        chart: Its map, by any method, without flips.
        lengths: 1 to keep lengths, 0 to keep angles, or between.
        pins: From the beginning.
        plane: (k, 2) [m] a map without flips to begin with instead of the chart's.
        whole: With more faces it follows by a coarse cage, where one can be made.
        name: The patch's name, for findings and errors.

    Raises:
        MapError: The chart is another surface's or has flips, or a pin is refused; see ``add``.

    Cost: 10 ms for 10,000 faces, and a first frame of 25 ms; 0.1 s for 50,000.
    """

    def __init__(
        self,
        surface: Mesh,
        chart: Chart,
        *,
        lengths: float = 1.0,
        pins: Sequence[Pin] = (),
        plane: FloatArray | None = None,
        whole: int = WHOLE,
        name: str = "patch",
    ) -> None:
        start = chart if plane is None else replace(chart, plane=plane)
        _check(surface, start, lengths, name)
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
        self._follower, self._uses_coarse_cage = self._following(start)
        for pin in pins:
            self.add(pin.at, pin.place)

    @property
    def plane(self) -> FloatArray:
        """(k, 2) [m] the present map."""
        return readonly(self._follower.plane * self._unit)

    @property
    def pins(self) -> Mapping[int, Pin]:
        """By number, in the order they were added."""
        return MappingProxyType(self._pins)

    @property
    def lags(self) -> FloatArray:
        """(p,) [m] how far each pin is from where it is wanted, in the order of ``pins``."""
        corners, weights, goals = self._held()
        there = np.einsum("pc,pcd->pd", weights, self._follower.plane[corners])
        return np.linalg.norm(there - goals, axis=1) * self._unit

    @property
    def lag(self) -> float:
        """How far the farthest pin is from where it is wanted [m]."""
        return float(self.lags.max(initial=0.0))

    @property
    def energy(self) -> float:
        """Of stretching, at the place of the slider, and of the springs; 4 is an isometry with all pins in place."""
        return self._follower.energy

    @property
    def still(self) -> bool:
        """Whether another frame would show nothing new."""
        return self._follower.still

    @property
    def uses_coarse_cage(self) -> bool:
        """Whether the frames follow by a coarse cage; ``converge`` never does."""
        return self._uses_coarse_cage

    def add(self, at: SurfacePoint, place: tuple[float, float] | FloatArray | None = None) -> int:
        """Put in a pin; its number.

        Args:
            at: Where on the body; which patch it names is not looked at.
            place: (x, y) where it is wanted [m]; where it is now if not given.

        Raises:
            MapError: There is no such place on the body, a pin is there already, or the place on the plane is no number
                or more than a hundred maps away.
        """
        weights = np.asarray(at.weights, dtype=np.float64)
        sound = np.isfinite(weights).all() and (weights > -1e-9).all() and abs(weights.sum() - 1) < 1e-6
        if not (0 <= at.face < len(self._chart.faces) and sound):
            raise MapError("a pin is not on the patch", place=self._name, value=f"face {at.face}, weights {at.weights}")
        here = weights @ self._follower.plane[self._chart.faces[at.face]]
        corners, others, _ = self._held()
        places = np.einsum("pc,pcd->pd", others, self._follower.plane[corners])
        if (np.abs(places - here).max(axis=1, initial=0.0) < 1e-9).any():
            raise MapError("there is a pin already", place=self._name, remedy="Drag that one")
        wanted = self._checked(here * self._unit if place is None else place)
        number = self._next
        self._next = self._next + 1
        self._pins[number] = Pin(at, wanted)
        self._follower.pin(*self._held())
        return number

    def move(self, pin: int, place: tuple[float, float] | FloatArray) -> None:
        """Want pin number ``pin`` at ``place`` (x, y) [m]; the next frames follow.

        Raises:
            MapError: No such pin, or no such place; see ``add``. All stays as it was.
        """
        self._known(pin)
        self._pins[pin] = Pin(self._pins[pin].at, self._checked(place))
        self._follower.aim(self._held()[2])

    def remove(self, pin: int) -> None:
        """Take out pin number ``pin``.

        Raises:
            MapError: There is no such pin.
        """
        self._known(pin)
        del self._pins[pin]
        self._follower.pin(*self._held())

    def frame(self) -> FloatArray:
        """Follow the pins for about a frame's time: the present map (k, 2) [m], never with a flip.

        While the pins stay, ``energy`` never rises. Pins that cannot all have their way stop where the map would fold;
        ``lag`` tells how far.

        Cost: at 10,000 faces 8 ms in the median, 18 ms with a new Hessian.
        """
        self._follower.frame()
        return self.plane

    def converge(self, *, on_round: OnRound | None = None) -> Chart:
        """The map at rest: converged, and with its border kept apart where it would lie on itself.

        Args:
            on_round: Told each round; may raise to cancel, and all stays as it was.

        Raises:
            MapError: No one-to-one map was found.

        Cost: see ``converge``; above a few thousand faces for a worker, to which ``pins`` and ``plane`` are given.
        """
        start = self._follower.plane
        job = ConvergenceJob(self._disk, self._pinned(), start, self._apart(start), self._chart, self._unit, self._name)
        chart = converge(job, on_round=on_round)
        self._chart, (self._follower, self._uses_coarse_cage) = chart, self._following(chart)
        self._follower.pin(*self._held())
        return chart

    def _apart(self, start: FloatArray) -> FloatArray:
        """A map that does not lie on itself, as near to ``start`` as there is one."""
        for plane in (start, self._chart.plane / self._unit):
            if not BoundaryBarrier(self._objective, self._disk.loop, plane).touches(plane):
                return plane
        return _laid_over(self._disk.start, start)

    def _following(self, start: Chart) -> tuple[PinFollower, bool]:
        """What follows from ``start``, and whether by a coarse cage."""
        plane = start.plane / self._unit
        if len(start.faces) > self._whole:
            try:
                cage = build_coarse_cage(self._surface, replace(start, plane=plane), name=self._name)
            except MapError:
                return PinFollower(self._objective, plane), False  # slower, and as good: ``uses_coarse_cage`` tells
            return PinFollower(self._objective, plane, cage=cage), True
        return PinFollower(self._objective, plane), False

    def _held(self) -> tuple[IntArray, FloatArray, FloatArray]:
        """Corners (p, 3), weights (p, 3) and goals (p, 2), in units."""
        pins = self._pins.values()
        corners = self._chart.faces[[pin.at.face for pin in pins]].reshape(-1, 3)
        weights = np.array([pin.at.weights for pin in pins], dtype=np.float64).reshape(-1, 3)
        return corners, weights, np.array([pin.place for pin in pins], dtype=np.float64).reshape(-1, 2) / self._unit

    def _pinned(self) -> PinnedEnergy:
        corners, weights, goals = self._held()
        return PinnedEnergy(self._objective, Springs(corners, weights), goals)

    def _known(self, pin: int) -> None:
        if pin not in self._pins:
            raise MapError("there is no such pin", place=self._name, value=pin)

    def _checked(self, place: tuple[float, float] | FloatArray) -> tuple[float, float]:
        x, y = (float(value) for value in place)
        off = np.abs(np.array([x, y]) - self._chart.plane.mean(axis=0)).max()
        if not off < _FARTHEST_PLACE * self._unit:
            raise MapError("a pin target is too far from the map", place=self._name, value=(x, y))
        return x, y


def _check(surface: Mesh, chart: Chart, lengths: float, name: str) -> None:
    if not 0 <= lengths <= 1:
        raise MapError("the slider between angles and lengths goes from 0 to 1", place=name, value=lengths)
    same = chart.faces.shape == surface.faces.shape and chart.vertex_of.max(initial=-1) < len(surface.vertices)
    sized = len(chart.plane) == len(chart.vertex_of)
    if not (same and sized and (chart.vertex_of[chart.faces] == surface.faces).all()):
        raise MapError("the chart is another surface's", place=name)
    if flips := int(flipped(chart.plane, chart.faces).sum()):
        raise MapError("the map has flipped triangles", place=name, value=flips, remedy="Flatten the patch first")


def _laid_over(plane: FloatArray, other: FloatArray) -> FloatArray:
    """``plane`` (k, 2) turned and moved to lie as ``other`` (k, 2) does."""
    flat = plane - plane.mean(axis=0)
    there = other - other.mean(axis=0)
    (a, b), (c, d) = np.einsum("ki,kj->ij", flat, there)
    angle = np.arctan2(b - c, a + d)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return np.asarray(flat @ turn + other.mean(axis=0))
