"""OBJ files with texture coordinates: read line by line, and a map out and back."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats import obj
from tactile_maps.maps.formats.obj import OBJ_METHOD, read_map_obj, read_obj, write_map_obj
from tactile_maps.maps.model.layout import MapLayout, Placement
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin
from tests.support.surfaces import frustum, named, sheet, skin_of

SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def read(tmp_path, text):
    (tmp_path / "map.obj").write_text(text)
    return read_obj(tmp_path / "map.obj")


def test_all_notations_of_a_corner_are_read(tmp_path):
    text = SQUARE + "mtllib x.mtl\nvn 0 0 1\ng lower part\nf 1/1/1 2/2/1 3/3/1\no upper\ns off\nf -4/-4 -2/-2 -1/-1\n"
    obj = read(tmp_path, text)
    assert obj.surface.faces.tolist() == obj.corners.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert obj.surface.area == 1
    assert (obj.groups, obj.group_of.tolist()) == (("lower part", "upper"), [0, 1])
    assert (obj.square, obj.findings) == (None, ())


def test_polygons_are_split_and_counted(tmp_path):
    obj = read(tmp_path, SQUARE + "# origin 0.1 -0.2 m, side 0.5 m\nf 1/1 2/2 3/3 4/4\n")
    assert obj.surface.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert [(f.kind, f.count) for f in obj.findings] == [("polygon", 1)]
    assert obj.group_of.tolist() == [-1, -1]
    assert obj.square == (0.1, -0.2, 0.5)


def test_vertex_may_have_additional_values(tmp_path):
    obj = read(tmp_path, "v 0 0 0 1.0 0.5 0\nv 1 0 0 1\nv 0 1 0\nvt 0 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n")
    assert obj.surface.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert obj.uv.tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "no faces"),
        (SQUARE, "no faces"),
        ("v 0 0\n", "line 1.*3 finite numbers.*0 0"),
        ("v 0 0 x\n", "line 1.*not a number"),
        ("v 0 0 nan\n", "line 1.*3 finite numbers"),
        ("v 0 0 1e30\n", "line 1.*3 finite numbers"),
        ("vt 0\n", "line 1.*2 finite numbers"),
        (SQUARE + "f 1 2 3\n", "line 9.*no texture coordinate.*Unwrap"),
        (SQUARE + "f 1//1 2//1 3//1\n", "line 9.*no texture coordinate"),
        (SQUARE + "f 1/1 2/2\n", "line 9.*three corners"),
        (SQUARE + "f 1/1 2/2 x/3\n", "line 9.*vertex/texture.*x/3"),
        (SQUARE + "f 1/1 2/2 5/3\n", "line 9.*not defined before.*5/3"),
        (SQUARE + "f 1/1 2/2 3/9\n", "line 9.*not defined before"),
        (SQUARE + "f 1/1 2/2 -5/3\n", "line 9.*not defined before"),
        (SQUARE + "f 1/1 2/2 0/3\n", "line 9.*not defined before"),
        (SQUARE + "f" + " 1/1" * 2000 + "\n", "line 9.*three corners"),
        ("# origin 0 0 m, side nan m\n", "line 1"),
    ],
)
def test_broken_files_are_rejected_with_line_and_value(tmp_path, text, problem):
    with pytest.raises(MapError, match=rf"map\.obj.*{problem}"):
        read(tmp_path, text)


def test_implausible_sizes_and_missing_files_are_rejected(tmp_path, monkeypatch):
    monkeypatch.setattr(obj, "MAX_LINES", 5)
    with pytest.raises(MapError, match="more than 5 lines"):
        read(tmp_path, SQUARE)
    with pytest.raises(MapError, match=r"nowhere\.obj.*cannot be read"):
        read_obj(tmp_path / "nowhere.obj")


@pytest.fixture(scope="module")
def one() -> TactileMap:
    """Open tube, which needs a seam."""
    return build_map(skin_of(frustum(along=8, around=16), taxels=30))


def kinds(map_: TactileMap) -> list[str]:
    return [finding.kind for chart in map_.charts for finding in chart.findings]


def as_other_tool(map_, path, *, change=lambda uv, k: uv, digits=6, seed=0, keep=lambda faces: faces):
    """The map as a tool might hand it back: own order of everything, a texture coordinate a corner, no remarks."""
    random = np.random.default_rng(seed)
    lines = []
    vertex = 1
    corner = 1
    for k, (patch, chart, uv) in enumerate(zip(map_.skin.patches, map_.charts, map_.uv, strict=True)):
        surface = patch.surface
        order = random.permutation(len(surface.vertices))
        faces = keep(random.permutation(len(surface.faces)))
        place = np.argsort(order)
        lines.append(f"o {patch.name.replace(' ', '_')}")
        lines += [f"v {x:.{digits}f} {y:.{digits}f} {z:.{digits}f}" for x, y, z in surface.vertices[order].tolist()]
        for face in faces.tolist():
            turn = np.roll(np.arange(3), random.integers(3))
            lines += [f"vt {u:.{digits}f} {v:.{digits}f}" for u, v in change(uv[chart.faces[face, turn]], k).tolist()]
            ends = place[surface.faces[face, turn]] + vertex
            lines.append("f " + " ".join(f"{end}/{corner + c}/1" for c, end in enumerate(ends.tolist())))
            corner += 3
        vertex += len(order)
    path.write_text("\n".join(lines))
    return path


def test_file_contains_the_body_and_the_map(three_patches, tmp_path):
    write_map_obj(three_patches, tmp_path / "map.obj")
    obj = read_obj(tmp_path / "map.obj")
    assert obj.groups == ("patch_0", "patch_1", "patch_2")
    assert (obj.uv.min(), obj.uv.max()) == (0, 1)
    surfaces = [patch.surface for patch in three_patches.skin.patches]
    body = np.concatenate([surface.vertices[surface.faces] for surface in surfaces])
    np.testing.assert_allclose(obj.surface.vertices[obj.surface.faces], body, atol=1e-8)
    flat = np.concatenate([uv[c.faces] for uv, c in zip(three_patches.uv, three_patches.charts, strict=True)])
    np.testing.assert_allclose(obj.uv[obj.corners] * obj.square[2] + obj.square[:2], flat, atol=1e-8)


def test_written_file_is_read_back(three_patches, tmp_path):
    write_map_obj(three_patches, tmp_path / "map.obj")
    back = read_map_obj(tmp_path / "map.obj", three_patches.skin)
    np.testing.assert_allclose(back.taxel_points, three_patches.taxel_points, atol=1e-8)
    assert kinds(back) == []
    for before, after in zip(three_patches.charts, back.charts, strict=True):
        assert after.method == OBJ_METHOD
        np.testing.assert_array_equal(after.vertex_of[after.faces], before.vertex_of[before.faces])
        assert {tuple(sorted(seam)) for seam in after.seams.tolist()} == {
            tuple(sorted(seam)) for seam in before.seams.tolist()
        }


@pytest.mark.parametrize("mirrored", [False, True])
def test_mirrored_placement_is_restored(one, tmp_path, mirrored):
    placed = TactileMap(one.skin, one.charts, MapLayout((Placement(0.7, (3.0, -1.0), mirrored),)))
    write_map_obj(placed, tmp_path / "map.obj")
    back = read_map_obj(tmp_path / "map.obj", one.skin)
    np.testing.assert_allclose(back.taxel_points, placed.taxel_points, atol=1e-8)
    assert back.layout.placements[0].mirrored == mirrored
    assert kinds(back) == ["mirrored-chart"] * mirrored


@pytest.mark.long
def test_map_is_restored_from_another_order_and_six_digits(three_patches, tmp_path):
    path = as_other_tool(three_patches, tmp_path / "map.obj")
    back = read_map_obj(path, three_patches.skin)
    np.testing.assert_allclose(back.taxel_points, three_patches.taxel_points, atol=1e-5)
    assert kinds(back) == ["scaled"]
    assert [len(c.seams) for c in back.charts] == [len(c.seams) for c in three_patches.charts]


@pytest.mark.long
def test_moved_scaled_and_mirrored_map_gets_its_true_area(three_patches, tmp_path):
    def change(uv, k):
        return 7.5 * uv * [-1, 1] + [40, -3]

    back = read_map_obj(as_other_tool(three_patches, tmp_path / "map.obj", change=change), three_patches.skin)
    assert kinds(back) == ["mirrored-chart", "scaled", "mirrored-chart", "mirrored-chart"]
    expected = three_patches.taxel_points * [-1, 1]
    shift = back.taxel_points - expected
    np.testing.assert_allclose(shift, np.broadcast_to(shift[0], shift.shape), atol=1e-5)
    assert "1 unit" not in back.charts[0].findings[1].action
    assert f"{1 / 7.5:.4f}" in back.charts[0].findings[1].action


@pytest.mark.long
def test_patches_with_different_scales_or_overlaps_are_arranged_again(three_patches, tmp_path):
    for change in (lambda uv, k: uv * (1 + k), lambda uv, k: uv - three_patches.uv[k].mean(axis=0)):
        back = read_map_obj(as_other_tool(three_patches, tmp_path / "map.obj", change=change), three_patches.skin)
        assert kinds(back) == ["scaled", "rearranged"]
        assert back.to_body(back.taxel_points[50]) is not None
        for before, after in zip(three_patches.charts, back.charts, strict=True):
            lengths = [np.linalg.norm(np.diff(c.plane[c.faces], axis=1), axis=2) for c in (before, after)]
            np.testing.assert_allclose(lengths[1], lengths[0], atol=2e-5)


@pytest.mark.long
def test_different_scales_alone_cause_rearrangement(three_patches, tmp_path):
    path = as_other_tool(three_patches, tmp_path / "map.obj", change=lambda uv, k: uv * (1 + 0.05 * k) + [5 * k, 0])
    assert kinds(read_map_obj(path, three_patches.skin)) == ["scaled", "rearranged"]


def test_crossing_patches_count_as_overlapping(tmp_path):
    strip = sheet(12, 2, width=0.3, height=0.03)
    map_ = build_map(skin_of(strip, strip, taxels=6))

    def change(uv, k):
        flat = uv - map_.uv[k].mean(axis=0)
        return flat @ [[0.0, 1.0], [-1.0, 0.0]] if k else flat

    crossed = as_other_tool(map_, tmp_path / "map.obj", change=change)
    assert kinds(read_map_obj(crossed, map_.skin)) == ["scaled", "rearranged"]


def test_patch_inside_another_counts_as_overlapping(tmp_path):
    ring = sheet(8, 8, width=0.4, height=0.4)
    coin = sheet(2, 2, width=0.05, height=0.05)
    map_ = build_map(skin_of(ring, coin, taxels=6))
    inside = as_other_tool(map_, tmp_path / "map.obj", change=lambda uv, k: uv - map_.uv[k].mean(axis=0))
    assert kinds(read_map_obj(inside, map_.skin)) == ["scaled", "rearranged"]


@pytest.mark.long
def test_faces_without_names_are_assigned_in_order(three_patches, tmp_path):
    path = as_other_tool(three_patches, tmp_path / "map.obj")
    path.write_text("\n".join(line for line in path.read_text().splitlines() if line[0] != "o"))
    back = read_map_obj(path, three_patches.skin)
    np.testing.assert_allclose(back.taxel_points, three_patches.taxel_points, atol=1e-5)


def test_different_seams_are_read_from_the_file(one, tmp_path):
    """A tube unrolled by hand, cut along another line than ours."""
    surface = one.skin.patches[0].surface
    own = {tuple(sorted(seam)) for seam in one.charts[0].seams.tolist()}
    start = next(v for v in range(16) if not any(v in seam for seam in own))
    turn = (np.arctan2(surface.vertices[:, 1], surface.vertices[:, 0]) - 2 * np.pi * start / 16 + 1e-9) % (2 * np.pi)
    uv = np.stack([0.04 * turn, surface.vertices[:, 2]], axis=1)[surface.faces]
    wrapped = np.ptp(uv[..., 0], axis=1) > 0.04
    uv[..., 0] += np.where(wrapped[:, None] & (uv[..., 0] < 0.04), 0.08 * np.pi, 0)
    lines = [f"v {x} {y} {z}" for x, y, z in surface.vertices] + [f"vt {u} {v}" for u, v in uv.reshape(-1, 2)]
    lines += [
        f"f {a + 1}/{3 * k + 1} {b + 1}/{3 * k + 2} {c + 1}/{3 * k + 3}" for k, (a, b, c) in enumerate(surface.faces)
    ]
    (tmp_path / "map.obj").write_text("\n".join(lines))
    back = read_map_obj(tmp_path / "map.obj", one.skin)
    seams = {tuple(sorted(seam)) for seam in back.charts[0].seams.tolist()}
    assert len(seams) == 8
    assert not seams & own
    assert all(v % 16 == start for seam in seams for v in seam)
    assert back.to_body(back.taxel_points[7]) is not None


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        ({"keep": lambda faces: faces[:-1]}, "does not have the skin's faces.*1 of 256 are missing"),
        ({"keep": lambda faces: np.append(faces[:-1], faces[0])}, "does not have the skin's faces.*1 of 256"),
        ({"digits": 2}, "does not have the skin's faces"),
        ({"change": lambda uv, k: np.zeros((3, 2))}, "flipped.*256 of 256"),
        ({"change": lambda uv, k: np.sort(uv, axis=0)}, "flipped"),
        (
            {"change": lambda uv, k: np.abs(uv - uv[0] * 0)[::-1] if uv[0, 0] > 0.1 else uv},
            "flipped|several pieces",
        ),
        ({"change": lambda uv, k: uv + (uv[:, :1].mean() > 0.1) * 5}, "is in several pieces.*Join"),
    ],
)
def test_file_that_is_not_a_map_of_the_skin_is_rejected(one, tmp_path, options, problem):
    path = as_other_tool(one, tmp_path / "map.obj", **options)
    with pytest.raises(MapError, match=rf"map\.obj.*patch 0.*({problem})"):
        read_map_obj(path, one.skin)


def test_closed_or_overlapping_unwrap_is_rejected(tmp_path):
    tube = frustum(along=3, around=8)
    skin = skin_of(tube, taxels=5)
    rings = tube.vertices[:, :2] * (1 + 3 * tube.vertices[:, 2:])  # a ring: flat, but not opened
    lines = [f"v {x} {y} {z}" for x, y, z in tube.vertices] + [f"vt {u} {v}" for u, v in rings]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in tube.faces + 1]
    (tmp_path / "map.obj").write_text("\n".join(lines))
    with pytest.raises(MapError, match="not cut open.*2 borders.*seam"):
        read_map_obj(tmp_path / "map.obj", skin)
    strip = sheet(12, 1, width=1.2, height=0.1)
    turn = 6 * strip.vertices[:, 0]
    wound = (0.15 + strip.vertices[:, 1:2]) * np.stack([-np.cos(turn), np.sin(turn)], axis=1)
    lines = [f"v {x} {y} {z}" for x, y, z in strip.vertices] + [f"vt {u} {v}" for u, v in wound]
    lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in strip.faces + 1]
    (tmp_path / "map.obj").write_text("\n".join(lines))
    with pytest.raises(MapError, match="overlaps itself.*crossings"):
        read_map_obj(tmp_path / "map.obj", skin_of(strip, taxels=5))


def test_map_of_another_skin_is_recognised_by_its_faces(one, tmp_path):
    write_map_obj(one, tmp_path / "map.obj")
    with pytest.raises(MapError, match="does not have the skin's faces"):
        read_map_obj(tmp_path / "map.obj", skin_of(named("saddle"), named("sheet"), taxels=5))
    with pytest.raises(MapError, match="map.obj"):
        read_map_obj(tmp_path / "map.obj", Skin(()))


def test_missing_folder_is_named(one, tmp_path):
    with pytest.raises(MapError, match="cannot be written"):
        write_map_obj(one, tmp_path / "no" / "map.obj")
