"""T-junctions are stitched, and nothing else: openings, slits and separate walls stay."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.remesh.repair import repair_mesh
from tactile_maps.geometry.remesh.stitch import open_cracks, stitch_junctions
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import GROUPS, hard_mesh, joined, loose, refined_at_random, scaled
from tests.support.cost import Cost, cost_of
from tests.support.surfaces import frustum, sphere


def counted(mesh: Mesh) -> dict[str, int]:
    return {finding.kind: finding.count for finding in repair_mesh(mesh).findings}


def pieces(mesh: Mesh) -> int:
    return int(repair_mesh(mesh).component.max()) + 1


def band(near: float, far: float, along_near: np.ndarray, along_far: np.ndarray) -> Mesh:
    """A flat band from y = ``near`` to ``far`` with vertices at the given x on its two sides."""
    faces = []
    i = 0
    j = 0
    first = len(along_near)
    while i < len(along_near) - 1 or j < len(along_far) - 1:
        if j == len(along_far) - 1 or (i < len(along_near) - 1 and along_near[i + 1] <= along_far[j + 1]):
            faces.append((i, i + 1, first + j))
            i += 1
        else:
            faces.append((i, first + j + 1, first + j))
            j += 1
    ends = [(x, near, 0.0) for x in along_near] + [(x, far, 0.0) for x in along_far]
    return Mesh(np.array(ends), np.array(faces))


ENDS = np.array([0.0, 1.0])
EVEN = np.linspace(0, 1, 9)


def bent(mesh: Mesh, by: float, axis: int) -> Mesh:
    """The vertices on the x axis moved aside, most in the middle."""
    vertices = mesh.vertices.copy()
    on = vertices[:, 1] == 0
    vertices[on, axis] += by * np.sin(np.pi * vertices[on, 0])
    return Mesh(vertices, mesh.faces)


@pytest.mark.parametrize("name", GROUPS["junctions"])
def test_mesh_refined_in_parts_becomes_one_surface_without_new_vertices(name: str) -> None:
    mesh = hard_mesh(name)
    repaired = repair_mesh(mesh)
    assert repaired.component.max() == 0
    assert counted(mesh)["t-junction"] > 0
    assert repaired.mesh.connectivity.agrees_in_direction
    assert len(repaired.mesh.connectivity.boundary_loops) == (name == "bricks")
    assert np.isin(repaired.mesh.vertices, mesh.vertices).all()
    assert np.array_equal(np.unique(repaired.face_of), np.arange(len(mesh.faces)))
    if "round" not in name:
        assert repaired.mesh.area == pytest.approx(mesh.area, rel=1e-12)


def test_parts_of_divided_face_are_inside_it_with_its_normal() -> None:
    mesh = refined_at_random(sphere(), 4)
    repaired = repair_mesh(mesh)
    parents = Mesh(mesh.vertices, mesh.faces)
    assert np.bincount(repaired.face_of, repaired.mesh.face_areas) == pytest.approx(parents.face_areas, rel=1e-9)
    assert ((repaired.mesh.face_normals * parents.face_normals[repaired.face_of]).sum(axis=1) > 0.999).all()


def test_each_vertex_inside_an_edge_is_counted_once() -> None:
    fine = band(0, 0.3, EVEN, EVEN)
    coarse = band(-0.3, 0, ENDS, ENDS)
    assert counted(joined(coarse, fine))["t-junction"] == 7
    assert "t-junction" not in counted(joined(fine, band(-0.3, 0, EVEN, EVEN)))


@pytest.mark.parametrize("gap", [0.0, 1e-6])
def test_alternating_subdivisions_are_stitched_from_both_sides(gap: float) -> None:
    rng = np.random.default_rng(0)
    first, second = (np.concatenate([[0], np.sort(rng.random(count)), [1]]) for count in (9, 14))
    mesh = joined(band(-0.2, 0, first, first), band(gap, 0.2, second, second))
    assert pieces(mesh) == 1
    assert counted(mesh)["t-junction"] == 23


@pytest.mark.sampled(3)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("how", ["unchanged", "loose", "turned"])
def test_stitching_depends_only_on_the_shape(scale: float, how: str) -> None:
    mesh = scaled(hard_mesh("round, refined at random"), scale)
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    mesh = {"unchanged": mesh, "loose": loose(mesh), "turned": Mesh(mesh.vertices @ turn, mesh.faces)}[how]
    assert pieces(mesh) == 1
    assert counted(mesh)["t-junction"] == counted(hard_mesh("round, refined at random"))["t-junction"]


@pytest.mark.parametrize("height", [0.001, 0.02, 0.049])
def test_crack_along_one_straight_edge_is_closed(height: float) -> None:
    for axis in (1, 2):
        mesh = joined(band(-0.3, 0, EVEN, ENDS), bent(band(0, 0.3, EVEN, EVEN), height, axis))
        assert len(repair_mesh(mesh).mesh.connectivity.boundary_loops) == 1
        assert counted(mesh)["t-junction"] == 7


def test_opening_wider_than_a_crack_stays_open() -> None:
    mesh = joined(band(-0.3, 0, EVEN, ENDS), bent(band(0, 0.3, EVEN, EVEN), 0.06, 1))
    assert len(repair_mesh(mesh).mesh.connectivity.boundary_loops) == 2
    assert "t-junction" not in counted(mesh)


@pytest.mark.parametrize("width", [1e-4, 0.01])
def test_slit_with_vertices_on_both_sides_stays_open(width: float) -> None:
    mesh = joined(band(-0.3, 0, EVEN, EVEN), bent(band(0, 0.3, EVEN, EVEN), width, 1))
    assert len(repair_mesh(mesh).mesh.connectivity.boundary_loops) == 2
    assert "t-junction" not in counted(mesh)


@pytest.mark.parametrize("width", [1e-4, 0.01])
def test_possible_crack_is_reported_with_its_widest_gap(width: float) -> None:
    mesh = scaled(joined(band(-0.3, 0, EVEN, EVEN), bent(band(0, 0.3, EVEN, EVEN), width, 1)), 2.0)
    (found,) = [finding for finding in repair_mesh(mesh).findings if finding.kind == "open-crack"]
    assert found.count == 16
    gap = (
        2e3 * width * (np.sin(np.pi / 2) + np.sin(3 * np.pi / 8)) / 2
    )  # of the middle of an edge next to the widest place
    assert f"up to {gap:.2g} mm apart" in found.action
    assert "merge their vertices" in found.action


@pytest.mark.parametrize(("noise", "closed"), [(2e-5, True), (1e-3, False)])
def test_rounded_junctions_on_both_sides_are_stitched_or_reported(noise: float, closed: bool) -> None:
    rng = np.random.default_rng(0)
    first, second = (np.concatenate([[0], np.sort(rng.random(count)), [1]]) for count in (9, 14))
    mesh = joined(band(-0.2, 0, first, first), band(0, 0.2, second, second))
    ends = np.isin(mesh.vertices[:, 0], [0, 1])[:, None]  # the sides have their ends in common
    rounded = Mesh(mesh.vertices + np.where(ends, 0, noise * rng.uniform(-1, 1, mesh.vertices.shape)), mesh.faces)
    counts = counted(rounded)
    assert pieces(rounded) == 1 if closed else counts["open-crack"] > 10
    assert ("open-crack" in counts) != closed
    assert (counts.get("t-junction") == 23) == closed
    assert "open-crack" not in counted(mesh)


@pytest.mark.parametrize("gap", [2e-6, 2e-5, 2e-4])
def test_fine_sheet_close_to_a_coarse_one_is_not_stitched(gap: float) -> None:
    coarse = band(0, 0.3, ENDS, ENDS)
    fine = band(0, 0.3, EVEN, EVEN)
    mesh = joined(coarse, Mesh(fine.vertices + [0, 0, gap], fine.faces))
    assert pieces(mesh) == 2
    assert not {"t-junction", "open-crack"} & counted(mesh).keys()


@pytest.mark.long
def test_cost_for_long_edges_over_many_loose_faces_is_linear() -> None:
    rng = np.random.default_rng(0)
    corner = np.concatenate([rng.random((20_000, 1, 2)), np.zeros((20_000, 1, 1))], axis=2)
    small = corner + 0.01 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    height = np.linspace(0, 1, 40)[:, None, None] * [0, 1, 0]
    soup = np.concatenate([small, height + [[0, 0, 0], [1, 0, 0], [1, 0, 0.3]]]).reshape(-1, 3)
    cost = cost_of(lambda: open_cracks(soup, np.arange(len(soup)).reshape(-1, 3)))
    assert cost.steps < 20_000
    assert cost.memory < 5_000 * len(soup)


def test_border_without_continuing_surface_is_not_a_crack() -> None:
    strip = band(0, 0.01, EVEN, EVEN)
    sheets = joined(band(0, 0.3, EVEN, EVEN), band(0, 0.3, ENDS, ENDS))
    apart = Mesh(
        sheets.vertices + np.where(np.arange(len(sheets.vertices)) < 18, 0.001, 0)[:, None] * [0, 0, 1], sheets.faces
    )
    wide = joined(band(-0.3, 0, EVEN, EVEN), band(0.02, 0.3, EVEN, EVEN))
    for mesh in (strip, apart, wide):
        assert "open-crack" not in counted(mesh)


@pytest.mark.parametrize("gap", [1e-4, 1e-3, 1e-2])
def test_walls_and_mouth_of_a_pocket_are_not_stitched(gap: float) -> None:
    coarse = band(-0.3, 0, EVEN, ENDS)
    fine = band(-0.3, 0, EVEN, EVEN)
    walls = joined(coarse, Mesh(fine.vertices + [0, 0, gap], fine.faces))
    assert pieces(walls) == 2
    pocket = joined(coarse, bent(fine, gap, 2))
    assert "t-junction" not in {**counted(walls), **counted(pocket)}


@pytest.mark.parametrize("inset", [0.0, 0.1])
@pytest.mark.parametrize("width", [1e-5, 1e-3, 0.04])
def test_narrow_strip_is_not_stitched_to_itself(width: float, inset: float) -> None:
    far = inset + (1 - 2 * inset) * EVEN
    assert "t-junction" not in counted(band(0, width, ENDS, far))
    middle = inset / 2 + (1 - inset) * EVEN
    assert "t-junction" not in counted(joined(band(0, width / 2, ENDS, middle), band(width / 2, width, middle, far)))


def test_corner_that_touches_an_edge_is_not_stitched() -> None:
    corner = Mesh([[0.5, 0, 0], [0.6, 0.2, 0], [0.4, 0.2, 0]], [[0, 1, 2]])
    mesh = joined(band(-0.3, 0, ENDS, ENDS), corner)
    assert pieces(mesh) == 2
    assert "t-junction" not in counted(mesh)


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", [name for group, names in GROUPS.items() if group != "junctions" for name in names])
def test_nothing_is_stitched_in_a_mesh_without_junctions(name: str) -> None:
    assert "t-junction" not in counted(hard_mesh(name))


def test_face_that_would_fold_over_is_unchanged() -> None:
    # The crack bulges past the far side of a flat coarse face.
    coarse = Mesh([[0, 0, 0], [1, 0, 0], [0.5, -0.01, 0]], [[0, 2, 1]])
    fine = bent(band(0, 0.3, EVEN, EVEN), -0.03, 1)
    assert "t-junction" not in counted(joined(coarse, fine))


def test_mesh_without_border_is_returned_unchanged() -> None:
    ball = sphere()
    faces, owner, count = stitch_junctions(ball.vertices, ball.faces)
    assert faces is ball.faces
    assert np.array_equal(owner, np.arange(len(faces)))
    assert count == 0


@pytest.mark.long
def test_cost_grows_with_the_number_of_junctions_only() -> None:
    def cost(subdivisions: int) -> tuple[int, Cost]:
        mesh = refined_at_random(sphere(radius=0.5, subdivisions=subdivisions), 1, radius=0.5)
        _, _, count = stitch_junctions(mesh.vertices, mesh.faces)
        assert count > 0.3 * len(mesh.faces)
        return count, cost_of(lambda: stitch_junctions(mesh.vertices, mesh.faces))

    few, low = cost(3)
    many, high = cost(5)
    assert many > 10 * few
    assert high.steps < 1.2 * low.steps
    assert high.memory / many < 1.5 * low.memory / few


def test_long_edge_next_to_many_short_ones_is_split_by_bisection() -> None:
    def cost(vertices: int, *, function: str | None = None) -> Cost:
        many = np.linspace(0, 1, vertices)
        tube = frustum(0.3, 0.3, length=0.5, around=40, along=2)
        mesh = joined(band(-0.3, 0, ENDS, ENDS), band(0, 1e-3, many, many), Mesh(tube.vertices + [0, 2, 0], tube.faces))
        welded = _welded(mesh)
        faces, _, count = stitch_junctions(*welded)
        assert count == vertices - 2
        assert Connectivity(faces).components.max() == 1
        return cost_of(lambda: stitch_junctions(*welded), function=function)

    few = cost(101)
    many = cost(401)
    assert many.steps < 1.5 * 4 * few.steps
    assert many.memory < 1.5 * 4 * few.memory
    few = cost(101, function="_divide")
    many = cost(401, function="_divide")
    assert 0 < few.steps < many.steps < 1.5 * few.steps


def _welded(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    vertices, faces = np.unique(mesh.vertices, axis=0, return_inverse=True)
    return vertices, faces[mesh.faces].reshape(-1, 3)
