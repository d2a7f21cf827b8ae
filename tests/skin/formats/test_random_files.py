"""Foreign files: what is written reads back, for every format, and no damage gets past the door without a name."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.obj import read_map_obj, write_map_obj
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.formats.icub.layout import (
    IcubLayout,
    LayoutModule,
    apply_layout,
    read_icub_layout,
)
from tactile_maps.skin.formats.icub.module_orientation import propose_orientations, reoriented
from tactile_maps.skin.formats.taxel_files import read_taxels, write_taxels
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_taxels import dome, strip, write_icub_layout
from tests.support.examples import examples
from tests.support.surfaces import frustum, sheet, skin_of

KEPT = {
    ".txt": ("numbers", "positions", "normals"),
    ".csv": ("numbers", "positions", "normals", "points", "modules"),
    ".npz": ("numbers", "positions", "normals", "points", "modules", "faces"),
    ".json": ("numbers", "positions", "normals", "points", "faces"),
    ".urdf": ("numbers", "positions", "normals"),
}
MAP = build_map(skin_of(sheet(6, 5), frustum(around=12, along=5), taxels=12))
lengths = st.floats(-9.9, 9.9, allow_subnormal=False)
names = st.one_of(st.none(), st.text(st.characters(min_codepoint=33, max_codepoint=0x2FFF), min_size=1, max_size=20))


def folder():
    return tempfile.TemporaryDirectory(prefix="tactile-maps-test-")


@st.composite
def taxel_sets(draw):
    count = draw(st.integers(1, 12))
    positions = draw(hnp.arrays(float, (count, 3), elements=lengths))
    apart = np.abs(positions[:, None] - positions).max(axis=2) + np.eye(count)
    assume(apart.min() > 1e-3 and positions.any(axis=1).all())  # a row of zeros is an unused one
    directions = draw(hnp.arrays(float, (count, 3), elements=st.floats(-1, 1)))
    long = np.linalg.norm(directions, axis=1, keepdims=True)
    points = draw(hnp.arrays(float, (count, 2), elements=lengths))
    points[draw(hnp.arrays(bool, count))] = np.nan
    faces = draw(hnp.arrays(np.int64, (draw(st.integers(1, 4)), 3), elements=st.integers(0, count - 1)))
    return TaxelSet(
        name="".join(draw(st.text(st.characters(codec="ascii", categories=["L", "N"]), min_size=1, max_size=9))),
        link=draw(names.filter(lambda name: name is None or (name.isprintable() and name == " ".join(name.split())))),
        numbers=np.array(draw(st.lists(st.integers(0, 2000), min_size=count, max_size=count, unique=True))),
        positions=positions,
        normals=directions / long if (long > 1e-3).all() and draw(st.booleans()) else None,
        faces=faces if draw(st.booleans()) else None,
        points=points if draw(st.booleans()) and not np.isnan(points).all() else None,
        modules=draw(hnp.arrays(np.int64, count, elements=st.integers(0, 99))) if draw(st.booleans()) else None,
    )


def by_number(taxels, name):
    values = getattr(taxels, name)
    return values if values is None or name == "faces" else values[np.argsort(taxels.numbers)]


@pytest.mark.long
@examples(100, suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow])
@given(taxel_sets(), st.sampled_from(sorted(KEPT)))
@example(dome(), ".txt")
def test_round_trip_keeps_taxels(taxels, ending):
    with folder() as where:
        path = Path(where) / f"set{ending}"
        write_taxels(taxels, path)
        back = read_taxels(path)
    assert back.link == (taxels.link or ("skin" if ending == ".urdf" else None))
    flat = ending == ".txt" and taxels.normals is not None and (taxels.normals == taxels.normals[0]).all()
    for name in KEPT[ending]:
        requested = by_number(taxels, name)
        found = by_number(back, name)
        if name == "normals" and flat:
            continue  # a single normal for all may be a placeholder and is reported as one
        assert (requested is None) == (found is None), name
        if requested is not None:
            np.testing.assert_allclose(found, requested, rtol=0, atol=1e-12 if name == "normals" else 0, err_msg=name)


@examples(40)
@given(st.lists(st.tuples(lengths, lengths, st.floats(-50, 50), st.booleans()), min_size=1, max_size=9))
def test_any_layout_reads_back(places):
    modules = tuple(LayoutModule(3 * k, x / 3, y / 3, turn, flip, k / 7) for k, (x, y, turn, flip) in enumerate(places))
    with folder() as where:
        write_icub_layout(IcubLayout("any", modules), Path(where) / "any.ini")
        back = read_icub_layout(Path(where) / "any.ini")
    np.testing.assert_array_equal(back.numbers, IcubLayout("any", modules).numbers)
    np.testing.assert_allclose(back.points, IcubLayout("any", modules).points, atol=1e-8)
    np.testing.assert_allclose([m.gain for m in back.modules], [m.gain for m in modules], rtol=1e-9)


@examples(25)
@given(st.lists(st.integers(0, 5), min_size=7, max_size=7), st.integers(0, 99))
def test_any_confusion_of_modules_is_corrected_or_leaves_no_torn_module(states, seed):
    taxels, true = strip(7)
    wrong = IcubLayout("strip", tuple(reoriented(m, s) for m, s in zip(true.modules, states, strict=True)))
    candidates = propose_orientations(taxels, wrong, seed=seed)
    assert candidates.torn_after == 0
    if not candidates.torn_before:
        assert candidates.apply(wrong) == wrong
        return
    right = apply_layout(taxels, candidates.apply(wrong)).points
    inner = np.isin(taxels.numbers // 12, candidates.modules[1:-1])
    np.testing.assert_allclose(right[inner], apply_layout(taxels, true).points[inner], atol=3e-5)


@examples(25)
@given(st.floats(-10, 10), st.tuples(lengths, lengths), st.booleans())
def test_any_map_reads_back_from_obj(angle, offset, mirrored):
    # The second patch is well apart from any position of the first.
    layout = MapLayout((Placement(angle, offset, mirrored), Placement(0.0, (50.0, 0.0))))
    moved = TactileMap(MAP.skin, MAP.charts, layout)
    with folder() as where:
        write_map_obj(moved, Path(where) / "map.obj")
        back = read_map_obj(Path(where) / "map.obj", MAP.skin)
    np.testing.assert_allclose(back.taxel_points, moved.taxel_points, atol=1e-6)
    assert [p.mirrored for p in back.layout.placements] == [mirrored, False]
