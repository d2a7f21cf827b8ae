"""One patch from the body to the plane: cut, first map, best map, proof."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from app.arrays import FloatArray
from app.errors import Finding, MapError
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops
from app.maps.bijective import crossings
from app.maps.border import ApartBorder
from app.maps.chart import Chart
from app.maps.cut import CutSurface, cut_to_disk, far_points, farthest_from_border
from app.maps.symmetric_dirichlet import Iterate, SymmetricDirichlet, minimise
from app.maps.tutte import tutte

METHODS = ("symmetric-dirichlet", "tutte")

WORTH_A_SEAM = 4.6
"""Mean energy above which one more seam is tried (a hemisphere has 4.14)."""
HOPELESS = 1e6
"""Mean energy of a first map from which no good one is reached in reasonable time."""
_MAX_SEAMS = 3
_WORTH_KEEPING = 0.1


def flatten(
    surface: Mesh,
    *,
    method: str = "symmetric-dirichlet",
    name: str = "patch",
    progress: Callable[[Iterate], None] | None = None,
) -> Chart:
    """Lay one connected, manifold surface flat, one-to-one.

    Args:
        surface: With any topology; it is cut to a disk first.
        method: ``symmetric-dirichlet`` (balanced angles and areas, the default) or ``tutte`` (always valid, distorted).
        name: The patch's name, for findings and errors.
        progress: Told each round; may raise to cancel.

    Raises:
        MapError: An unknown method, or a surface that cannot be cut or opened.
    """
    if method not in METHODS:
        raise MapError("there is no such method", place="method", value=method, remedy=f"Choose {' or '.join(METHODS)}")
    if not surface.area > 0:
        raise MapError("the surface has no area to lay flat", place=name, value=f"{len(surface.faces)} faces")
    cut, terminals = _openable(surface, name)
    notes = [Finding("seam-added", name, "too deep to open without", len(terminals))] if terminals else []
    chart = _flatten_cut(surface, cut, method, name, progress)
    while method != "tutte" and chart.energies[-1] > WORTH_A_SEAM and len(terminals) < _MAX_SEAMS:
        cut, terminals = _with_seam(surface, cut, terminals)
        better = _flatten_cut(surface, cut, method, name, progress)
        before, after = chart.energies[-1], better.energies[-1]
        if before - after < _WORTH_KEEPING * (before - 4):
            break
        notes.append(Finding("seam-added", name, f"distortion {before:.2f} -> {after:.2f} (4 is none)"))
        chart = better
    return replace(chart, findings=(*chart.findings, *notes))


def _openable(surface: Mesh, name: str) -> tuple[CutSurface, list[int]]:
    """A cut whose first map is valid, and the ends of the seams it took besides those the topology asks for.

    On a long, deep cup the first map shrinks the bottom towards the smallest number; a seam into it lets it open.
    """
    cut, terminals = cut_to_disk(surface), list[int]()
    while not _first_energy(surface, cut) < HOPELESS:
        if len(terminals) == _MAX_SEAMS:
            raise MapError(
                "the surface is too long and thin for a first map",
                place=name,
                value=f"{len(cut.faces)} faces",
                remedy="Cover the link with more taxels, or split it",
            )
        cut, terminals = _with_seam(surface, cut, terminals)
    return cut, terminals


def _first_energy(surface: Mesh, cut: CutSurface) -> float:
    problem, start = _posed(surface, cut)
    return problem.energy(start)


def _posed(surface: Mesh, cut: CutSurface) -> tuple[SymmetricDirichlet, FloatArray]:
    """The energy and the first map, both of unit area, so that no tolerance depends on the unit of length."""
    positions = surface.vertices[cut.vertex_of]
    start = tutte(positions, cut.faces)
    problem = SymmetricDirichlet((positions - positions.mean(axis=0)) / np.sqrt(surface.area), cut.faces)
    return problem, start / np.sqrt(_area(start, cut))


def _with_seam(surface: Mesh, cut: CutSurface, terminals: list[int]) -> tuple[CutSurface, list[int]]:
    """One seam more, to the place farthest from border and seams so far."""
    more = [*terminals, farthest_from_border(surface, cut)]
    # A closed surface is cut between two points anyway; those stay.
    ends = more if boundary_loops(surface.faces) else [*far_points(surface), *more]
    return cut_to_disk(surface, terminals=ends), more


def _flatten_cut(
    surface: Mesh, cut: CutSurface, method: str, name: str, progress: Callable[[Iterate], None] | None
) -> Chart:
    positions = surface.vertices[cut.vertex_of]
    problem, start = _posed(surface, cut)
    rounds, findings = [Iterate(start, problem.energy(start), 0.0, 1.0)], []
    if problem.mollified:
        findings.append(Finding("thin-face", name, "given the least area that can be laid flat", problem.mollified))
    if method == "symmetric-dirichlet":
        rounds, overlapped = _optimised(problem, start, cut, progress)
        if overlapped:
            findings.append(Finding("overlap-avoided", name, f"border kept apart, distortion {rounds[-1].energy:.2f}"))
    plane = rounds[-1].plane * np.sqrt(surface.area / _area(rounds[-1].plane, cut))
    energies, seconds = tuple(r.energy for r in rounds), tuple(r.seconds for r in rounds)
    upright = _upright(plane, positions)
    return Chart(cut.faces, upright, cut.vertex_of, cut.seams, method, energies, seconds, tuple(findings))


def _optimised(
    problem: SymmetricDirichlet, start: FloatArray, cut: CutSurface, progress: Callable[[Iterate], None] | None
) -> tuple[list[Iterate], bool]:
    """The rounds to the best map that does not overlap itself, and whether the very best would have.

    The first map does not overlap, and a barrier between the border's parts keeps it so.
    """
    rounds = _collect(minimise(problem, start), progress)
    if not crossings(_border(rounds[-1].plane, cut)):
        return rounds, False
    apart = ApartBorder(problem, boundary_loops(cut.faces)[0], rounds[-1].plane)
    rounds = _collect(minimise(apart, start), progress)
    return [replace(r, energy=problem.energy(r.plane)) for r in rounds], True


def _collect(iterates: Iterable[Iterate], progress: Callable[[Iterate], None] | None) -> list[Iterate]:
    rounds: list[Iterate] = []
    for iterate in iterates:
        rounds.append(iterate)
        if progress is not None:
            progress(iterate)
    return rounds


def _border(plane: FloatArray, cut: CutSurface) -> FloatArray:
    return plane[boundary_loops(cut.faces)[0]]


def _area(plane: FloatArray, cut: CutSurface) -> float:
    loop = _border(plane, cut)
    after = np.roll(loop, -1, axis=0)
    return float(0.5 * (loop[:, 0] * after[:, 1] - loop[:, 1] * after[:, 0]).sum())


def _upright(plane: FloatArray, positions: FloatArray) -> FloatArray:
    """Turn so that the body's long direction, away from the link's origin (its joint), points up; box at the origin."""
    centred = positions - positions.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    axis = axes[0] * (1.0 if axes[0] @ positions.mean(axis=0) >= 0 else -1.0)
    flat = plane - plane.mean(axis=0)
    gradient, *_ = np.linalg.lstsq(flat, centred @ axis, rcond=None)
    length = float(np.linalg.norm(gradient))
    up = gradient / length if length > 1e-9 else np.array([0.0, 1.0])
    turned = flat @ np.array([[up[1], up[0]], [-up[0], up[1]]])
    return turned - turned.min(axis=0)
