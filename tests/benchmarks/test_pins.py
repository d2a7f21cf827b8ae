"""Dragging a pin: our frame compared with an iteration of libigl's SLIM, which precomputes again at each move.

    .venv/bin/python -m pytest tests/benchmarks/test_pins.py --benchmark-enable

One of six pins is dragged around a circle of a quarter of the map in 60 frames. In addition to the time the table lists
flipped faces over all frames, the largest and the median lag of a pin (shares of the map's size), and the excess of the
last frame's energy over the minimum.
"""

from __future__ import annotations

import time
from functools import cache

import igl
import numpy as np
import pytest

from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.flatten import flatten
from tactile_maps.flattening.initial_map import Disk
from tactile_maps.flattening.newton import minimise
from tactile_maps.flattening.pin_descent import STIFFNESS, PinnedEnergy, Springs
from tactile_maps.flattening.pinned_patch import PinnedPatch
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tests.benchmarks.flatten_meshes import MESHES

SIZES = (1000, 5000, 10_000, 20_000, 50_000)
"""Numbers of faces; the largest for our method only, because SLIM takes a second for a frame there."""
_TRIED = 400
_FRAMES = 60
_PINS = 6
_CIRCLE = 0.25


@cache
def posed(name, faces):
    """Return the patch, its map, the pinned vertices, and the path of the dragged one."""
    surface = MESHES[name][1](faces)
    chart = flatten(surface)
    plane = chart.plane
    chosen = [int(np.argmin(np.linalg.norm(plane - plane.mean(axis=0), axis=1)))]
    while len(chosen) < _PINS:
        chosen.append(int(np.linalg.norm(plane[:, None] - plane[chosen], axis=2).min(axis=1).argmax()))
    angle = 2 * np.pi * np.arange(_FRAMES) / _FRAMES
    radius = _CIRCLE / 2 * np.ptp(plane, axis=0).min()
    path = plane[chosen[0]] + radius * np.stack([np.cos(angle) - 1, np.sin(angle)], axis=1)
    return surface, chart, chosen, path


class Tally:
    """Quality of the frames of a drag."""

    def __init__(self, name, faces):
        self.surface, self.chart, self.chosen, self.path = posed(name, faces)
        self.unit = np.sqrt(self.surface.area)
        self.flips = 0
        self.lags = []
        self.milliseconds = []

    def frame(self, step, place):
        begin = time.perf_counter()
        plane = step(place)
        self.milliseconds.append(1e3 * (time.perf_counter() - begin))
        self.flips += int(flipped(plane, self.chart.faces).sum())
        goals = self.chart.plane[self.chosen].copy()
        goals[0] = place
        self.lags.append(np.linalg.norm(plane[self.chosen] - goals, axis=1).max() / self.unit)
        return plane, goals

    def above(self, plane, goals):
        """Return the relative excess of the energy with springs over its minimum."""
        positions = self.surface.vertices[self.chart.vertex_of] / self.unit
        problem = Disk(Mesh(positions, self.chart.faces)).energy
        corners = self.chart.faces[[at(self.chart, v).face for v in self.chosen]]
        weights = (corners == np.array(self.chosen)[:, None]).astype(float)
        energy = PinnedEnergy(problem, Springs(corners, weights), goals / self.unit)
        *_, least = minimise(energy, plane / self.unit, tolerance=1e-6)
        return energy.energy(plane / self.unit) / least.energy - 1

    def report(self, benchmark, plane, goals):
        share = f"{100 * self.above(plane, goals):.2g} %" if np.isfinite(plane).all() and self.flips == 0 else "-"
        benchmark.extra_info.update(
            faces=len(self.chart.faces),
            flips=self.flips,
            lag=f"{max(self.lags):.0e} / {np.median(self.lags):.0e}",
            above=share,
        )


def at(chart, vertex):
    face = int(np.flatnonzero((chart.faces == vertex).any(axis=1))[0])
    return SurfacePoint(0, face, tuple((chart.faces[face] == vertex).astype(float).tolist()))


def ours(tally, **how):
    patch = PinnedPatch(tally.surface, tally.chart, **how)
    numbers = [patch.add(at(tally.chart, vertex)) for vertex in tally.chosen]
    patch.frame()

    def step(place):
        patch.move(numbers[0], place)
        return patch.frame()

    return step


def slim(tally):
    """Measure libigl's SLIM with soft pins, whose targets are part of its precomputation."""
    positions = tally.surface.vertices[tally.chart.vertex_of] / tally.unit
    faces = tally.chart.faces.astype(np.int64)
    kind = igl.MappingEnergyType.SYMMETRIC_DIRICHLET
    pins = np.array(tally.chosen, dtype=np.int64)
    now = [tally.chart.plane / tally.unit]

    def step(place):
        goals = (tally.chart.plane[tally.chosen] / tally.unit).copy()
        goals[0] = place / tally.unit
        data = igl.slim_precompute(positions, faces, now[0].copy(), kind, pins, goals, STIFFNESS)
        now[0] = np.asarray(igl.slim_solve(data, 1))[:, :2]
        return now[0] * tally.unit

    return step


@pytest.mark.parametrize(("how", "faces"), [*(("ours", n) for n in SIZES), *(("slim", n) for n in SIZES[:-1])])
@pytest.mark.parametrize("name", ["bump", "torso", "tapered, bent forearm"])
def test_pin_drag(benchmark, how, name, faces):
    tally = Tally(name, _TRIED if benchmark.disabled else faces)
    step = ours(tally) if how == "ours" else slim(tally)
    frames = iter(tally.path)
    last = []

    def once():
        last[:] = tally.frame(step, next(frames))

    benchmark.pedantic(once, rounds=1 if benchmark.disabled else _FRAMES, warmup_rounds=0)
    tally.report(benchmark, *last)
    assert np.isfinite(last[0]).all()
    if how == "ours":
        assert tally.flips == 0


@pytest.mark.parametrize("faces", [10_000, 20_000])
def test_pin_drag_with_all_faces(benchmark, faces):
    """Measure a drag without the coarse cage."""
    tally = Tally("bump", _TRIED if benchmark.disabled else faces)
    step = ours(tally, whole=10**9)
    frames = iter(tally.path)
    last = []

    def once():
        last[:] = tally.frame(step, next(frames))

    benchmark.pedantic(once, rounds=1 if benchmark.disabled else _FRAMES, warmup_rounds=0)
    tally.report(benchmark, *last)
    assert tally.flips == 0


@pytest.mark.parametrize("faces", [10_000, 20_000])
def test_settling_after_a_drag(benchmark, faces):
    """Measure the job that runs on release, with the pin after a quarter of the circle."""
    tally = Tally("torso", _TRIED if benchmark.disabled else faces)

    def dragged():
        patch = PinnedPatch(tally.surface, tally.chart)
        numbers = [patch.add(at(tally.chart, vertex)) for vertex in tally.chosen]
        for place in tally.path[:15]:
            patch.move(numbers[0], place)
            patch.frame()
        return (patch,), {}

    chart = benchmark.pedantic(lambda patch: patch.converge(), setup=dragged, rounds=1 if benchmark.disabled else 5)
    assert not flipped(chart.plane, chart.faces).any()
