"""Coarser links: made once a robot, kept as bytes, and never taken for those of another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import FOLDER_VARIABLE
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.load import robot_of_mesh
from tactile_maps.session import prepared_cache
from tactile_maps.session.link_levels import LinkLevels, faces_of_links, links_digest
from tactile_maps.session.prepared_cache import cache_content, clear_cache, link_levels_cached


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "kept"))
    return tmp_path / "kept"


@pytest.fixture(scope="module")
def robot():
    """A block of many triangles."""
    made = pv.Box((0.0, 0.1, 0.0, 0.1, 0.0, 0.1), level=12).triangulate().clean()
    mesh = Mesh(np.asarray(made.points, float), made.regular_faces)
    return robot_of_mesh(mesh, name="block", source="block", link="block")


def test_levels_are_written_and_read(robot):
    made = LinkLevels.make(robot)
    assert made.links[0]
    errors = [level.error for level in made.links[0]]
    assert errors == sorted(set(errors))
    assert len(made.links[0][-1].faces) < 0.1 * faces_of_links(robot)
    back = LinkLevels.from_bytes(made.to_bytes(), robot)
    assert back.digest == made.digest == links_digest(robot)
    for one, other in zip(made.links, back.links, strict=True):
        assert [level.error for level in one] == [level.error for level in other]
        for level, same in zip(one, other, strict=True):
            np.testing.assert_array_equal(level.faces, same.faces)


def test_placeholder_of_a_missing_mesh_has_no_levels(robot):
    missing = replace(robot, links=tuple(replace(link, missing=("gone.stl",)) for link in robot.links))
    assert not any(LinkLevels.make(missing).links)
    assert links_digest(missing) != links_digest(robot)


def test_faces_with_unknown_vertices_are_rejected(robot):
    mesh = robot.links[0].mesh
    assert mesh is not None
    small = Mesh(mesh.vertices[:3], np.array([[0, 1, 2]]))
    other = replace(robot, links=(replace(robot.links[0], mesh=small), *robot.links[1:]))
    with pytest.raises(RecordingError, match="vertices that it does not have"):
        LinkLevels.from_bytes(LinkLevels.make(robot).to_bytes(), other)


def test_levels_are_cached_but_do_not_count_as_scenes(robot, monkeypatch):
    made = link_levels_cached(robot)
    monkeypatch.setattr(prepared_cache.LinkLevels, "make", None)  # not again
    assert link_levels_cached(robot).digest == made.digest
    assert cache_content().entries == 0
    assert cache_content().size > 0
    clear_cache()
    assert cache_content().size == 0


@pytest.mark.long
def test_damaged_levels_are_computed_again(robot, folder):
    link_levels_cached(robot)
    (path,) = folder.iterdir()
    path.write_bytes(path.read_bytes()[:-40])
    assert link_levels_cached(robot).links[0]
    assert LinkLevels.from_bytes(path.read_bytes(), robot).links[0]
