"""Flattening of one patch: cut, flattened by any method, repaired if not one-to-one, and verified."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, MapError, check_range
from tactile_maps.flattening import methods
from tactile_maps.flattening.bijectivity import BoundaryBarrier, crossings, flipped
from tactile_maps.flattening.chart import Chart, canonical_pose
from tactile_maps.flattening.cut import CutSurface, SeamPlan, planned_cuts
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.flattening.methods import Method, find_method
from tactile_maps.flattening.newton import DescentStopped, Iterate, OnRound, minimise
from tactile_maps.geometry.surface.mesh import Mesh

WORTH_A_SEAM = 4.6
"""Mean energy above which one more seam is tried (a hemisphere has 4.14)."""
EASY_ENERGY = 1e6
"""Mean energy of a first map up to which no further seams are tried."""
GIVEN_UP_ENERGY = 1e7
"""Mean energy of a first map below which the search stops after a seam that does not help."""
HARDEST_ENERGY = 1e10
"""Largest mean energy of a first map: 20,000 faces with 81 handles begin at 7e6 and take 30 CPU s."""
TAUTEST_ENERGY = 1e12
"""Largest mean energy of a stretched slender patch. Needles of 10,000 radii in rungs for 1000 taxels begin at 7e10
and reach 4.2; those of 100,000 begin at 1.7e12, fold, and do not converge within a minute."""
MOST_FACE_ROUNDS = 60_000_000
"""Largest product of faces and rounds of a patch's descents: about 30 CPU s. Counted instead of timed, so that the map
does not depend on the speed of the machine."""
_LEAST_ROUNDS = 100
"""Rounds that any patch may take, regardless of its number of faces."""
_BARRIER_COST = 8
"""Cost of a round with the border's barrier relative to one without."""
_MOST_SEAMS = 3
_SEAMS_TO_OPEN = (0, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)
"""Numbers of extra seams tried for an initial map: a body with limbs needs one for each limb."""
_WORTH_KEEPING = 0.1


def flatten(
    surface: Mesh,
    *,
    method: str = "symmetric-dirichlet",
    lengths: float = 1.0,
    seams: SeamPlan | None = None,
    name: str = "patch",
    on_round: OnRound | None = None,
) -> Chart:
    """Flatten one connected, manifold surface one-to-one, as a bijective parameterization.

    Args:
        surface: Any topology; it is cut to a disk first.
        method: A name in ``flattening.methods``. Where its map would flip or overlap, the built-in minimiser computes
            the closest valid one, reported as a finding.
        lengths: 1 keeps lengths, 0 keeps angles; for methods with this parameter.
        seams: Requested seams; by default those that the topology requires and those that are worth it.
        name: The patch's name, for findings and errors.
        on_round: Called after each round; may raise to cancel.

    Raises:
        MapError: An unknown method, or a surface that cannot be cut or opened.
    """
    how = find_method(method)
    plan = seams or SeamPlan()
    check_range("the share of lengths", lengths, 0, 1, error=MapError, place="lengths")
    if not surface.area > 0:
        raise MapError("the surface has no area to flatten", place=name, value=f"{len(surface.faces)} faces")
    job = _FlatteningJob(surface, how, lengths, plan, name, on_round)
    extra = job.openable()
    notes = (
        [Finding("seam-added", name, "without it the surface is too deep to flatten", extra)]
        if plan.extra is None and extra
        else []
    )
    chart, reached = job.flatten(extra)
    while job.seeks_seams and not job.spent and reached > WORTH_A_SEAM and extra < _MOST_SEAMS:
        extra += 1
        better, after = job.flatten(extra)
        if reached - after < _WORTH_KEEPING * (reached - 4):
            break
        notes.append(Finding("seam-added", name, f"distortion {reached:.2f} -> {after:.2f} (4 is isometric)"))
        chart = better
        reached = after
    return replace(chart, findings=(*chart.findings, *notes))


class _FlatteningJob:
    """Flattening of one surface by one method with as many seams as necessary."""

    def __init__(
        self, surface: Mesh, how: Method, lengths: float, plan: SeamPlan, name: str, on_round: OnRound | None
    ) -> None:
        self._surface = surface
        self._how = how
        self._lengths = lengths
        self._plan = plan
        self._name = name
        self._on_round = on_round
        self._further_cuts = planned_cuts(surface, plan)
        self._rounds = 0
        self._most_rounds = max(MOST_FACE_ROUNDS / len(surface.faces), _LEAST_ROUNDS)
        self._converged = True  # whether the last descent converged
        self._cuts: list[CutSurface] = []
        self._disks: dict[int, tuple[CutSurface, Disk]] = {}

    @property
    def seeks_seams(self) -> bool:
        """Whether seams may be added automatically; other methods use only those that the topology requires."""
        return self._how.name == "symmetric-dirichlet" and self._plan.extra is None

    @property
    def spent(self) -> bool:
        """Whether the descents have used all allowed rounds."""
        return self._rounds >= self._most_rounds

    def openable(self) -> int:
        """Return the number of extra seams with which a descent from the first map succeeds.

        Raises:
            MapError: There is no such number.
        """
        extra = self._least_hopeless()
        _, disk = self._cut(extra)
        energy = disk.energy.energy(disk.taut)
        if self._how.slides and energy > TAUTEST_ENERGY:
            across = float(disk.rest.edge_lengths.min() * np.sqrt(self._surface.area))
            raise MapError(
                "the surface is too long and thin to be flattened",
                place=self._name,
                value=f"{self._surface.size:.3g} m long with edges of {across:.3g} m, {len(self._surface.faces)} faces",
                remedy="Cut off or thicken its needles, or ask for fewer taxels",
            )
        return extra

    def _least_hopeless(self) -> int:
        """Return the number of extra seams with which the first map has a moderate energy, or the least energy.

        On a long, deep cup the initial map shrinks the bottom towards the smallest number; a seam into it opens it. A
        body with limbs needs a seam into almost each of them: a limb without a seam is lost in rounding.
        """
        requested = self._plan.extra or 0
        best = requested
        least = np.inf
        for extra in sorted({requested, *(count for count in _SEAMS_TO_OPEN if count > requested)}):
            _, disk = self._cut(extra)
            energy = disk.energy.energy(disk.start)
            if energy < EASY_ENERGY:
                return extra
            # Stop where seams do not help, as on a surface with many handles. Larger energies are dominated by the limb
            # closest to being lost in rounding and say nothing about the next seam.
            settled = least < GIVEN_UP_ENERGY and energy > 0.1 * least
            if energy < least:
                best = extra
                least = energy
            if settled:
                break
        if least < HARDEST_ENERGY:
            return best
        raise MapError(
            "no initial map of the surface was found",
            place=self._name,
            value=f"{len(self._surface.faces)} faces, up to {extra} extra seams",
            remedy="Remove its thinnest limbs or needles, or split it into several patches",
        )

    def _cut(self, extra: int) -> tuple[CutSurface, Disk]:
        if extra not in self._disks:
            while len(self._cuts) <= extra:
                self._cuts.append(next(self._further_cuts))
            self._disks[extra] = self._cuts[extra], Disk.of(self._surface, self._cuts[extra])
        return self._disks[extra]

    def flatten(self, extra: int) -> tuple[Chart, float]:
        """Return the chart with ``extra`` more seams, and the energy that the method or the slider minimises."""
        cut, disk = self._cut(extra)
        rounds, findings = self._valid(disk)
        best = rounds[-1].plane
        plane = canonical_pose(best * np.sqrt(self._surface.area), self._surface.vertices[cut.vertex_of])
        if flipped(plane, cut.faces).any() or crossings(plane[disk.loop]):
            raise MapError("no one-to-one map was found", place=self._name, remedy="Split the patch, or draw a seam")
        if disk.energy.mollified:
            note = Finding(
                "thin-face", self._name, "enlarged to the least area that can be flattened", disk.energy.mollified
            )
            findings.append(note)
        energies = tuple(r.energy for r in rounds)
        seconds = tuple(r.seconds for r in rounds)
        chart = Chart(cut.faces, plane, cut.vertex_of, cut.seams, self._how.name, energies, seconds, tuple(findings))
        return chart, rounds[-1].energy if self._lengths == 1 else methods.blended_energy(disk, self._lengths).energy(
            best
        )

    def _valid(self, disk: Disk) -> tuple[list[Iterate], list[Finding]]:
        """Return rounds that end in a map without flips and overlaps, and the findings."""
        findings = list[Finding]()
        begin = time.perf_counter()
        rounds: list[Iterate] = []
        try:
            rounds += self._recorded(disk, begin, self._how.run(disk, self._lengths))
        except RuntimeError as error:  # how libigl reports a singular system
            findings.append(
                Finding("method-failed", self._name, f"{self._how.name}: {error}; the built-in method was used instead")
            )
        target = methods.blended_energy(disk, self._lengths if self._how.slides else self._how.lengths)
        if not rounds or not np.isfinite(rounds[-1].energy):
            if not findings:
                findings.append(
                    Finding("flips-mended", self._name, f"{self._how.name} flips triangles on this surface")
                )
            rounds += self._recorded(disk, begin, (r.plane for r in minimise(target, disk.taut)))
        apart = BoundaryBarrier(target, disk.loop, rounds[-1].plane)
        if apart.touches(rounds[-1].plane):
            # The first map does not overlap, and a barrier between parts of the border preserves this.
            rounds += self._recorded(disk, begin, (r.plane for r in minimise(apart, disk.taut)), cost=_BARRIER_COST)
            note = f"boundary barrier, distortion {rounds[-1].energy:.2f}"
            findings.append(Finding("overlap-avoided", self._name, note))
        if not self._converged:
            note = f"after {len(rounds)} rounds, distortion {rounds[-1].energy:.4g} (4 is isometric)"
            findings.append(Finding("descent-stopped", self._name, note))
        return rounds, findings

    def _recorded(self, disk: Disk, begin: float, planes: Iterable[FloatArray], *, cost: int = 1) -> list[Iterate]:
        """Return each plane at unit area with its energy and time: at least one, then while rounds are left."""
        rounds = list[Iterate]()
        try:
            for plane in planes:
                self._rounds += cost
                scaled = disk.scaled(plane)
                energy = disk.energy.energy_at_best_scale(scaled)
                rounds.append(Iterate(scaled, energy, time.perf_counter() - begin))
                if self._on_round is not None:
                    self._on_round(rounds[-1])
                if self.spent:
                    break
            self._converged = not self.spent
        except DescentStopped:
            self._converged = False
        return rounds
