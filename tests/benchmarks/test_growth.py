"""Growth of each stage's time with faces or taxels: CPU time by size, and the fitted exponent."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.flattening.cut import cut_to_disk
from tactile_maps.flattening.flatten import flatten
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.encoding.frame_codec import encode_frame
from tactile_maps.session.session import Session
from tactile_maps.studies.testbeds.reference_bodies import bumpy_shell, closed_link, flat_map
from tactile_maps.tactile.press import press_skin
from tests.benchmarks.test_tick import covered, touched

FACES = (1_000, 10_000, 100_000)
TAXELS = (100, 1_000, 10_000, 100_000)
ARM = (300, 1_000, 3_000, 10_000)
_AT_LEAST = 0.05
"""Shortest total time over which a quick function is repeated [s]."""

map_of = cache(flat_map)
shell = cache(bumpy_shell)
link = cache(closed_link)


@cache
def session(taxels: int) -> Session:
    return touched(covered(taxels), "hybrid", 1)


def cpu(work: Callable[[], object]) -> float:
    """Return the mean CPU time of a call [s], over repetitions after a first call that is not counted."""
    work()
    rounds = 0
    began = time.process_time()
    while rounds == 0 or time.process_time() - began < _AT_LEAST:
        work()
        rounds += 1
    return (time.process_time() - began) / rounds


def _press(taxels: int) -> Callable[[], object]:
    skin = map_of(taxels).skin
    return lambda: press_skin(skin, skin.taxel_point(len(skin) // 2), force=2.0)


def _read(taxels: int) -> Callable[[], object]:
    map_ = map_of(taxels)
    pressures = press_skin(map_.skin, map_.skin.taxel_point(len(map_.skin) // 2), force=2.0)
    detector = ContactDetector(map_)
    return lambda: detector.read(pressures.copy(), time=0.0)


def _back(map_: TactileMap) -> Callable[[], object]:
    points = map_.taxel_points[np.random.default_rng(0).integers(len(map_.taxel_points), size=1_000)]
    return lambda: map_.to_body_many(points)


def _show(taxels: int) -> Callable[[], object]:
    image = TactileImage(map_of(taxels), width=256)
    pressures = np.ones(len(map_of(taxels).skin))
    return lambda: image.render(pressures)


def _encode(taxels: int) -> Callable[[], object]:
    frame = session(taxels).frame
    return lambda: encode_frame(frame)


def _whole(surface: Mesh) -> Callable[[], object]:
    return lambda: flatten(surface)


STAGES: dict[str, tuple[tuple[int, ...], Callable[[int], Callable[[], object]]]] = {
    "cut of a closed link, faces": (FACES, lambda faces: lambda: cut_to_disk(link(faces))),
    "flattening of a bumpy shell, faces": (FACES, lambda faces: _whole(shell(faces))),
    "map with taxels from nothing, taxels": (TAXELS, lambda taxels: lambda: flat_map(taxels)),
    "thousand points back to the body, taxels": (TAXELS, lambda taxels: _back(map_of(taxels))),
    "tactile image made, taxels": (TAXELS, lambda taxels: lambda: TactileImage(map_of(taxels), width=256)),
    "tactile image of a reading, taxels": (TAXELS, _show),
    "finger pressed on the skin, taxels": (TAXELS, _press),
    "contact read, taxels": (TAXELS, _read),
    "tick of the arm with a task, taxels": (ARM, lambda taxels: session(taxels).tick),
    "frame encoded, taxels": (ARM, _encode),
}


@pytest.mark.parametrize("stage", STAGES)
def test_time_grows_with_size_at_most_as_stated(benchmark, stage):
    sizes, work = STAGES[stage]
    sizes = sizes if benchmark.enabled else sizes[:1]
    seconds = benchmark.pedantic(lambda: [cpu(work(size)) for size in sizes], rounds=3 if benchmark.enabled else 1)
    if len(sizes) > 1:
        exponent = np.polyfit(np.log(sizes), np.log(seconds), 1)[0]
        last = np.log(seconds[-1] / seconds[-2]) / np.log(sizes[-1] / sizes[-2])
        times = ", ".join(f"{size:,}: {1e3 * one:.3g}" for size, one in zip(sizes, seconds, strict=True))
        benchmark.extra_info["ms_cpu"] = times
        benchmark.extra_info["exponent"] = f"{exponent:.2f}, at the end {last:.2f}"
