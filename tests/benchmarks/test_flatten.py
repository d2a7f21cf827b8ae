"""Our flattening compared with libigl's SLIM and, if a Python with these packages is given, xatlas and Blender.

    TACTILE_MAPS_PEERS=/path/to/python .venv/bin/python -m pytest tests/benchmarks/test_flatten.py --benchmark-enable

The peers' Python needs ``bpy`` and ``xatlas``. Every method gets the same disk and is timed until its energy is within
1 % of the lowest that any method reached, so that further digits do not count.
"""

from __future__ import annotations

import os
import subprocess
import time
from pathlib import Path

import igl
import numpy as np
import pytest

from tactile_maps.core.arrays import FloatArray
from tactile_maps.flattening.bijectivity import BoundaryBarrier, crossings, flipped
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.symmetric_dirichlet import SymmetricDirichlet
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh
from tests.benchmarks.flatten_meshes import MESHES, disk_of
from tests.benchmarks.flatten_table import FLATTENING, Run

PEERS = os.environ.get("TACTILE_MAPS_PEERS")
FACES = 8000
LARGE = 100_000
_TRIED = 400
_SLIM_ROUNDS = 60
_BLENDER_ITERATIONS = (3, 10, 30, 100)


def ours(surface_disk: Disk) -> Run:
    """Run all steps of ``flatten`` on a cut disk."""
    begin = time.perf_counter()
    disk = Disk(Mesh(surface_disk.positions, surface_disk.faces))
    rounds = [(r.plane, time.perf_counter() - begin) for r in minimise(disk.energy, disk.start)]
    if crossings(rounds[-1][0][disk.loop]):
        apart = BoundaryBarrier(disk.energy, disk.loop, rounds[-1][0])
        rounds = [(r.plane, time.perf_counter() - begin) for r in minimise(apart, disk.start)]
    return judged("ours", disk, rounds)


def slim(surface_disk: Disk) -> Run:
    """Run libigl's SLIM from the same start."""
    begin = time.perf_counter()
    disk = Disk(Mesh(surface_disk.positions, surface_disk.faces))
    none = np.zeros(0, dtype=np.int64)
    nowhere = np.zeros((0, 2))
    kind = igl.MappingEnergyType.SYMMETRIC_DIRICHLET
    data = igl.slim_precompute(disk.positions, disk.faces, disk.start.copy(), kind, none, nowhere, 0.0)
    rounds = [(disk.start, time.perf_counter() - begin)]
    judging = 0.0
    for _ in range(_SLIM_ROUNDS):
        rounds.append((np.asarray(igl.slim_solve(data, 1))[:, :2], time.perf_counter() - begin - judging))
        judging_start = time.perf_counter()
        still = disk.energy.energy(rounds[-2][0]) - disk.energy.energy(rounds[-1][0])
        judging += time.perf_counter() - judging_start
        if still <= 1e-4 * (disk.energy.energy(rounds[-1][0]) - 4):
            break
    return judged("libigl SLIM", disk, rounds)


def judged(method: str, disk: Disk, rounds: list[tuple[FloatArray, float]]) -> Run:
    energies = tuple(disk.energy.energy_at_best_scale(plane) for plane, _ in rounds)
    last = rounds[-1][0]
    flips = int(flipped(last, disk.faces).sum())
    overlaps = crossings(last[disk.loop])
    return Run(method, tuple(s for _, s in rounds), energies, flips, overlaps)


def peer(method: str, disk: Disk, folder: Path, *arguments: str) -> Run:
    """Run a program with the peers' Python."""
    source = folder / "disk.npz"
    target = folder / "map.npz"
    np.savez(source, vertices=disk.positions, faces=disk.faces)
    script = Path(__file__).with_name("flatten_peer.py")
    subprocess.run([PEERS, script, method, source, target, *arguments], check=True, capture_output=True)
    with np.load(target) as found:
        corners = found["corners"]
        seconds = float(found["seconds"])
    plane, back = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    faces = back.reshape(-1, 3)
    # Values for each corner, because the peer may have cut: its disk has a vertex for each corner.
    loose = np.arange(disk.faces.size).reshape(-1, 3)
    energy = SymmetricDirichlet(Mesh(disk.positions[disk.faces].reshape(-1, 3), loose))
    # A chart that is mirrored as a whole has no flip.
    chart = Connectivity(faces).components
    turned = np.bincount(chart, flipped(corners.reshape(-1, 2), loose)) > 0.5 * np.bincount(chart)
    mirror = np.where(turned[chart][:, None, None], [-1.0, 1.0], 1.0)
    unglued = (corners * mirror).reshape(-1, 2)
    flips = int(flipped(unglued, loose).sum())
    charts = int(chart.max()) + 1
    overlaps = crossings(plane[Connectivity(faces).boundary_loops[0]]) if charts == 1 and not flips else 0
    return Run(method, (seconds,), (energy.energy_at_best_scale(unglued),), flips, overlaps, charts)


def blender(disk: Disk, folder: Path) -> Run:
    """Run minimum stretch with increasing numbers of iterations, each timed from its start."""
    runs = [peer("blender-min-stretch", disk, folder, str(count)) for count in _BLENDER_ITERATIONS]
    last = runs[-1]
    seconds = tuple(run.seconds[0] for run in runs)
    return Run("Blender min. stretch", seconds, tuple(r.energies[0] for r in runs), last.flips, last.overlaps)


def compared(disk: Disk, folder: Path) -> list[Run]:
    runs = [ours(disk), slim(disk)]
    if PEERS and len(disk.faces) < LARGE / 2:  # at 100,000 faces a run of Blender takes minutes
        runs += [blender(disk, folder), peer("blender-angle", disk, folder), peer("xatlas", disk, folder)]
    return runs


def test_ours_and_slim_reach_the_same_energy_on_a_small_mesh():
    disk = disk_of(MESHES["bump"][1](400))
    mine = ours(disk)
    theirs = slim(disk)
    assert mine.flips == mine.overlaps == theirs.flips == 0
    assert mine.best < 4.9
    assert mine.best == pytest.approx(theirs.best, rel=1e-3)


@pytest.mark.parametrize(("name", "faces"), [*((name, FACES) for name in MESHES), ("bump", LARGE), ("lumpy", LARGE)])
def test_flattening_of_a_mesh_without_flips_or_overlaps(request, benchmark, tmp_path, name, faces):
    kind, make = MESHES[name]
    disk = disk_of(make(_TRIED if benchmark.disabled else faces))
    runs = [ours(disk)] if benchmark.disabled else compared(disk, tmp_path)
    benchmark.pedantic(lambda: ours(disk), rounds=1 if benchmark.disabled else 3)
    if not benchmark.disabled:
        request.config.stash.setdefault(FLATTENING, []).append((name, kind, len(disk.faces), runs))
    assert runs[0].flips == 0
    assert runs[0].overlaps == 0
