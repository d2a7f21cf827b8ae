"""The tactile image: a frame compared with SciPy's interpolators, building, and growth from 100 to 100,000 taxels."""

from __future__ import annotations

import time

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator, griddata
from scipy.spatial import Delaunay

from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.studies.sweeps.image_cost import smooth
from tactile_maps.studies.testbeds.reference_bodies import flat_map

WIDTH = 256


@pytest.fixture(scope="module")
def thousand():
    map_ = flat_map(1024)
    assert map_.to_body(map_.taxel_points[0]) is not None, "the map's own search is built before the image is timed"
    return map_


def _median_ms(action, rounds=5):
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        action()
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_frame_of_256_by_256_from_1024_taxels(benchmark, thousand, interpolation):
    image = TactileImage(thousand, width=WIDTH, interpolation=interpolation)
    values = smooth(thousand.taxel_points)
    assert image.shape == (WIDTH, WIDTH)
    benchmark.pedantic(image.render, (values,), rounds=300, warmup_rounds=20)
    if benchmark.stats is not None:
        points = thousand.taxel_points
        centres = image.centres()
        triangles = Delaunay(points)
        theirs = _median_ms(lambda: griddata(points, values, centres))
        prebuilt = _median_ms(lambda: LinearNDInterpolator(triangles, values)(centres))
        ours = 1e3 * float(np.median(benchmark.stats.stats.data))
        benchmark.extra_info["griddata takes"] = f"{theirs / ours:.0f} times as long ({theirs:.1f} ms)"
        benchmark.extra_info["LinearNDInterpolator, built before"] = f"{prebuilt / ours:.0f} times ({prebuilt:.1f} ms)"
        error = 1e3 * image.render(values).ravel() - smooth(centres)
        benchmark.extra_info["rms error, to the border"] = f"{np.sqrt(np.mean(error**2)):.5f}"


@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
def test_building_256_by_256_for_1024_taxels(benchmark, thousand, interpolation):
    image = benchmark.pedantic(
        TactileImage, (thousand,), {"width": WIDTH, "interpolation": interpolation}, rounds=5, warmup_rounds=1
    )
    benchmark.extra_info["weights"] = f"{image.weights.nnz / image.shown.sum():.1f} a pixel"


@pytest.mark.parametrize("width", [64, 128, 256, 512, 1024])
def test_building_barycentric_by_width(benchmark, thousand, width):
    benchmark.pedantic(TactileImage, (thousand,), {"width": width}, rounds=5, warmup_rounds=1)


@pytest.mark.parametrize("taxels", [100, 1000, 10_000, 100_000])
def test_frame_of_256_by_256_for_increasing_numbers_of_taxels(benchmark, taxels):
    map_ = flat_map(taxels)
    image = TactileImage(map_, width=WIDTH)
    values = smooth(map_.taxel_points)
    benchmark.pedantic(image.render, (values,), rounds=100, warmup_rounds=5)
    if benchmark.stats is not None:
        benchmark.extra_info["build"] = f"{_median_ms(lambda: TactileImage(map_, width=WIDTH), 3):.0f} ms"


def test_pixel_areas_of_256_by_256_from_1024_taxels(benchmark, thousand):
    image = TactileImage(thousand, width=WIDTH)
    areas = benchmark.pedantic(lambda: TactileImage.pixel_areas.func(image), rounds=5, warmup_rounds=1)
    kept = image.weights.T.astype(np.float64) @ areas.ravel()
    error = np.abs(kept / thousand.skin.areas - 1).max()
    assert error < 1e-12
    benchmark.extra_info["force error"] = f"{error:.0e}"
