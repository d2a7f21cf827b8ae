"""Random meshes broken at random: each gets a map that is one-to-one and exact, or a named error; none crashes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import Phase, event, given
from hypothesis import strategies as st

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.skin.mesh_skin import skin_of_mesh
from tactile_maps.skin.taxel_placement.placement import PlacementSpec
from tests.hard_cases.mesh_checks import check_map, check_skin
from tests.support.child_process import Child
from tests.support.examples import examples
from tests.support.surfaces import cap, eight, frustum, sheet, sphere, torus

SHAPES = {
    "sheet": lambda: sheet(6, 5, shape=lambda x, y: 4 * x * y),
    "tube": lambda: frustum(0.05, 0.03, around=10, along=6),
    "cap": lambda: cap(1.0, rings=5),
    "ball": lambda: sphere(subdivisions=1),
    "torus": lambda: torus(around=10, across=6),
    "two handles": eight,
}
BREAKS = (
    "lose faces",
    "repeat faces",
    "turn faces",
    "loosen corners",
    "glue vertices",
    "collapse vertices",
    "add faces",
    "flatten",
    "stretch",
    "shrink a face",
    "unit",
    "offset",
    "not a number",
    "bad index",
)
TAXELS = 8
SECONDS = 120.0


def broken(vertices: np.ndarray, faces: np.ndarray, how: str, rng: np.random.Generator) -> tuple:
    """The mesh with one kind of damage more."""
    some = rng.random(len(faces)) < 0.15
    few = rng.integers(len(vertices), size=4)
    points = vertices.copy()
    if how == "lose faces":
        return vertices, faces[~some]
    if how == "repeat faces":
        return vertices, np.concatenate([faces, np.roll(faces[some], 1, axis=1), faces[some][:, ::-1]])
    if how == "turn faces":
        return vertices, np.where(some[:, None], faces[:, ::-1], faces)
    if how == "loosen corners":
        return vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)
    if how == "glue vertices":
        return vertices, np.where(np.isin(faces, few[:2]), few[0], faces)
    if how == "add faces":
        return vertices, np.concatenate([faces, rng.integers(len(vertices), size=(5, 3))])
    if how == "bad index":
        return vertices, np.concatenate([faces, [[0, 1, len(vertices)]]])
    if how == "not a number":
        points[few] = [np.nan, 1.0, np.inf]
    if how == "collapse vertices":
        points[few] = vertices[few[0]]
    if how == "shrink a face":
        points[faces[0]] = points[faces[0, 0]] + 10.0 ** rng.uniform(-14, -3) * rng.normal(size=(3, 3))
    scale = {"flatten": [1, 1, 1e-5], "stretch": [100, 1, 1], "unit": 10.0 ** rng.uniform(-6, 6)}.get(how, 1.0)
    offset = 1e6 * rng.normal(size=3) if how == "offset" else 0.0
    return points * scale + offset, faces


def outcome(shape: str, breaks: tuple[str, ...], seed: int) -> str:
    """Runs in a child: the laws for one broken mesh."""
    rng = np.random.default_rng(seed)
    mesh = SHAPES[shape]()
    vertices = mesh.vertices
    faces = mesh.faces
    for how in breaks:
        if len(faces):
            vertices, faces = broken(vertices, faces, how, rng)
    try:
        skin = skin_of_mesh(Mesh(vertices, faces), PlacementSpec(taxels=TAXELS, seed=seed), surface="all")
        map_ = build_map(check_skin(skin, TAXELS))
    except TactileMapsError as error:
        return f"refused: {error.problem}"
    check_map(map_)
    return "mapped"


@pytest.fixture(scope="module")
def child() -> Iterator[Child]:
    process = Child()
    yield process
    process.close()


@pytest.mark.long
@examples(60, derandomize=True, phases=[Phase.generate])  # a hang is not worth shrinking
@given(
    shape=st.sampled_from(sorted(SHAPES)),
    breaks=st.lists(st.sampled_from(BREAKS[:-2]), max_size=5, unique=True).map(tuple),
    seed=st.integers(0, 10_000),
)
def test_broken_mesh_is_mapped_or_rejected_by_name(
    child: Child, shape: str, breaks: tuple[str, ...], seed: int
) -> None:
    event(child.call(outcome, shape, breaks, seed, seconds=SECONDS))


@pytest.mark.long
@pytest.mark.rotating
@pytest.mark.parametrize("how", BREAKS[:-2])
@pytest.mark.parametrize("shape", sorted(SHAPES))
def test_mesh_with_a_single_kind_of_damage_is_always_mapped(child: Child, shape: str, how: str) -> None:
    assert child.call(outcome, shape, (how,), 1, seconds=SECONDS) == "mapped"


@pytest.mark.long
@pytest.mark.parametrize("how", BREAKS[-2:])
def test_invalid_mesh_is_rejected(child: Child, how: str) -> None:
    answer = child.call(outcome, "tube", (how,), 1, seconds=SECONDS)
    assert answer.startswith("refused: a ")


@pytest.mark.long
def test_every_kind_of_damage_changes_the_mesh() -> None:
    mesh = SHAPES["torus"]()
    for how in BREAKS:
        vertices, faces = broken(mesh.vertices, mesh.faces, how, np.random.default_rng(1))
        assert not (np.array_equal(vertices, mesh.vertices) and np.array_equal(faces, mesh.faces)), how
