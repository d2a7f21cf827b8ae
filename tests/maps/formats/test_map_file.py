"""Map files: what is saved comes back, and nothing unsound gets in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError, SkinError
from tactile_maps.core.files import pack_arrays, unpack_arrays
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.map_file import load_map, map_from_bytes, map_to_bytes, save_map
from tactile_maps.maps.formats.obj import write_map_obj
from tactile_maps.maps.model.layout import MapLayout
from tests.support.surfaces import named, skin_of


def _changed(map_, *, header=None, **arrays):
    """The map's bytes with parts replaced; None removes an array."""
    old_header, old = unpack_arrays(map_to_bytes(map_), error=MapError)
    merged = {key.lstrip("_"): value for key, value in (old | {k.lstrip("_"): v for k, v in arrays.items()}).items()}
    return pack_arrays(old_header | (header or {}), {k: v for k, v in merged.items() if v is not None})


def test_saved_data_are_restored(three_patches, tmp_path):
    save_map(three_patches, tmp_path / "map.npz")
    back = load_map(tmp_path / "map.npz")
    assert map_to_bytes(back) == map_to_bytes(three_patches)
    np.testing.assert_array_equal(back.taxel_points, three_patches.taxel_points)
    assert back.layout == three_patches.layout
    assert [chart.energies for chart in back.charts] == [chart.energies for chart in three_patches.charts]
    assert [path.name for path in tmp_path.iterdir()] == ["map.npz"], "no half-written file is left"


def test_findings_are_restored():
    map_ = build_map(skin_of(named("nearly closed")))
    assert map_.charts[0].findings
    assert map_from_bytes(map_to_bytes(map_)).charts[0].findings == map_.charts[0].findings


@pytest.mark.sampled(5)
@pytest.mark.parametrize(
    ("header", "says"),
    [
        ({"format": "tactile-maps-skin"}, "not a map file"),
        ({"version": 99}, "unknown version"),
        ({"methods": ["a"]}, "header is broken"),
        ({"methods": [1, 2, 3]}, "header is broken"),
        ({"findings": None}, "header is broken"),
        ({"findings": [[["kind", "where", "action", "many"]], [], []]}, "header is broken"),
        ({"placements": [[0.0, 0.0, 0.0]] * 3}, "header is broken"),
        ({"placements": [[0.0, 1e300, 0.0, False]] * 3}, "header is broken"),
        ({"placements": [[0.0, float("nan"), 0.0, False]] * 3}, "header is broken"),
        ({"placements": [[0.0, 0.0, 0.0, 1]] * 3}, "header is broken"),
    ],
)
def test_broken_header_is_rejected(three_patches, header, says):
    with pytest.raises(MapError, match=says):
        map_from_bytes(_changed(three_patches, header=header), file="bad.npz")


def _bad_arrays(map_):
    chart = map_.charts[0]
    swapped = chart.faces[:, ::-1].copy()
    far = chart.faces.copy()
    nan = chart.plane.copy()
    turned = chart.plane * [-1, 1]
    far[0, 0] = 10**9
    nan[3, 1] = np.nan
    one_less = chart.vertex_of[:-1].copy()
    other = chart.vertex_of.copy()
    other[0] += 1
    return [
        ("faces", None, "missing"),
        ("faces", far, "out of range"),
        ("faces", -chart.faces - 1, "out of range"),
        ("faces", chart.faces.astype(float), "wrong shape or type"),
        ("faces", chart.faces[:-1], "not of this patch"),
        ("faces", swapped, "not of this patch"),
        ("plane", nan, "not finite"),
        ("plane", turned, "flipped"),
        ("plane", chart.plane[:, :1], "wrong shape"),
        ("vertex_of", one_less, "differ in number"),
        ("vertex_of", other, "not of this patch"),
        ("vertex_of", chart.vertex_of + 10**6, "out of range"),
        ("seams", chart.seams + 10**6, "out of range"),
        ("seconds", np.array([np.inf]), "not finite"),
        ("energies", np.float64(4), "wrong shape"),
    ]


@pytest.mark.sampled(5)
@pytest.mark.parametrize("case", range(15))
def test_broken_array_is_rejected_with_file_patch_and_name(three_patches, case):
    name, values, says = _bad_arrays(three_patches)[case]
    with pytest.raises(MapError, match=says) as caught:
        map_from_bytes(_changed(three_patches, **{f"_0_{name}": values}), file="bad.npz")
    assert "bad.npz" in str(caught.value)
    assert "patch 0" in str(caught.value)


def test_chart_that_is_not_a_disk_is_rejected():
    """The right faces in the right place, but with the tube's ends left open: two borders."""
    map_ = build_map(skin_of(named("tube")))
    surface = map_.skin.patches[0].surface
    turn = np.arctan2(surface.vertices[:, 1], surface.vertices[:, 0])
    height = surface.vertices[:, 2]
    ring = (0.1 + height)[:, None] * np.stack([np.cos(-turn), np.sin(-turn)], axis=1)
    parts = {"_0_faces": surface.faces, "_0_vertex_of": np.arange(len(surface.vertices)), "_0_plane": ring}
    with pytest.raises(MapError, match=r"not a disk.*2 borders"):
        map_from_bytes(_changed(map_, **parts))


def test_map_without_valid_skin_is_rejected(three_patches):
    with pytest.raises(MapError, match="no skin"):
        map_from_bytes(_changed(three_patches, skin=None))
    with pytest.raises(SkinError):
        map_from_bytes(_changed(three_patches, skin=np.zeros(10, np.uint8)))


@pytest.mark.parametrize("data", [b"", b"PK", b"\x93NUMPY", bytes(1000)])
def test_bytes_of_another_kind_are_rejected(data):
    with pytest.raises(MapError, match="damaged or of another kind"):
        map_from_bytes(data)


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.999])
def test_truncated_file_is_rejected(three_patches, share):
    data = map_to_bytes(three_patches)
    with pytest.raises(MapError):
        map_from_bytes(data[: int(share * len(data))])


def test_missing_file_is_named(tmp_path):
    with pytest.raises(MapError, match=r"nowhere\.npz"):
        load_map(tmp_path / "nowhere.npz")


def test_missing_folder_is_named_without_data_loss(three_patches, tmp_path):
    with pytest.raises(MapError, match="cannot be written"):
        save_map(three_patches, tmp_path / "no" / "map.npz")


def test_obj_contains_the_body_and_the_map(three_patches, tmp_path):
    write_map_obj(three_patches, tmp_path / "map.obj")
    lines = [line.split() for line in (tmp_path / "map.obj").read_text().splitlines()]
    v = np.array([line[1:] for line in lines if line[0] == "v"], dtype=float)
    vt = np.array([line[1:] for line in lines if line[0] == "vt"], dtype=float)
    corners = np.array([[corner.split("/") for corner in line[1:]] for line in lines if line[0] == "f"], dtype=int) - 1
    groups = [line[1] for line in lines if line[0] == "g"]
    assert groups == ["patch_0", "patch_1", "patch_2"]
    assert (vt.min(), vt.max()) == (0, 1)
    surfaces = [patch.surface for patch in three_patches.skin.patches]
    body = np.concatenate([surface.vertices[surface.faces] for surface in surfaces])
    np.testing.assert_allclose(v[corners[..., 0]], body, atol=1e-8)
    low, high = three_patches.bounds
    flat = np.concatenate([uv[c.faces] for uv, c in zip(three_patches.uv, three_patches.charts, strict=True)])
    np.testing.assert_allclose(vt[corners[..., 1]] * (high - low).max() + low, flat, atol=1e-8)


def test_older_file_without_patch_scales_is_read(three_patches):
    header, arrays = unpack_arrays(map_to_bytes(three_patches), error=MapError)
    old = header | {"version": 1, "placements": [entry[:4] for entry in header["placements"]]}
    assert map_from_bytes(pack_arrays(old, arrays)).layout == three_patches.layout


@pytest.mark.long
def test_patch_scale_is_restored_and_an_implausible_one_rejected(three_patches):
    places = [replace(place, scale=2.5, mirrored=True) for place in three_patches.layout.placements]
    scaled = replace(three_patches, layout=MapLayout(tuple(places)))
    assert map_from_bytes(map_to_bytes(scaled)).layout == scaled.layout
    header, arrays = unpack_arrays(map_to_bytes(three_patches), error=MapError)
    for scale in (0.0, -1.0, 1e9, float("nan"), 1, "1"):
        broken = header | {"placements": [[*entry[:4], scale] for entry in header["placements"]]}
        with pytest.raises(MapError, match="header is broken"):
            map_from_bytes(pack_arrays(broken, arrays))


def test_existing_file_is_replaced_only_on_request(three_patches, tmp_path):
    path = tmp_path / "map.npz"
    path.write_bytes(b"precious")
    with pytest.raises(MapError, match=r"already exists.*\(overwrite=True\)"):
        save_map(three_patches, path)
    assert path.read_bytes() == b"precious"
    save_map(three_patches, path, overwrite=True)
    assert map_to_bytes(load_map(path)) == map_to_bytes(three_patches)
