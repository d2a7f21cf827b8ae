from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import signed_areas
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.maps.build import build_map
from tactile_maps.maps.formats.unige import unige_file_of, write_unige_map
from tactile_maps.skin.formats.taxel_files import read_taxels
from tactile_maps.skin.formats.unige_json import read_unige
from tests.support.surfaces import frustum, named, skin_of


@pytest.fixture(scope="module")
def tube():
    return build_map(skin_of(frustum(along=16, around=32), taxels=150))


def test_written_file_is_read_back(tube, tmp_path):
    write_unige_map(tube, tmp_path / "skin.json", name="tube")
    file = read_unige(tmp_path / "skin.json")
    expected = unige_file_of(tube)
    taxels = tube.skin.patches[0].taxels
    np.testing.assert_array_equal(file.taxels.positions, taxels.positions)
    np.testing.assert_allclose(file.taxels.normals, taxels.normals, atol=1e-15)
    np.testing.assert_array_equal(file.taxels.faces, expected.taxels.faces)
    assert (file.taxels.link, file.taxels.findings) == ("link 0", ())
    (drawn,) = file.maps
    assert (drawn.name, drawn.description) == ("tube", "made by Tactile Maps: symmetric-dirichlet")
    np.testing.assert_array_equal(drawn.points, tube.taxel_points)
    np.testing.assert_array_equal(drawn.faces, expected.maps[0].faces)
    np.testing.assert_array_equal(read_taxels(tmp_path / "skin.json").points, tube.taxel_points)


def test_map_is_the_body_cut_along_the_seam(tube):
    file = unige_file_of(tube)
    body = file.taxels.faces
    flat = file.maps[0].faces
    assert (Connectivity(body).euler_characteristic, len(Connectivity(body).boundary_loops)) == (0, 2)
    assert (Connectivity(flat).euler_characteristic, len(Connectivity(flat).boundary_loops)) == (1, 1)
    assert (signed_areas(file.maps[0].points, flat) > 0).all()
    assert 0 < len(body) - len(flat) < 40


def test_no_face_is_stretched_across_a_seam():
    ball = build_map(skin_of(named("sphere"), taxels=150))
    file = unige_file_of(ball)
    corners = file.taxels.positions[file.maps[0].faces]
    flat = file.maps[0].points[file.maps[0].faces]
    true, drawn = (np.linalg.norm(c - np.roll(c, 1, axis=1), axis=2) for c in (corners, flat))
    assert (drawn <= 2 * true).all()
    assert len(file.maps[0].faces) > 200


def test_unige_map_of_a_skin_on_several_links_is_rejected(three_patches, tmp_path):
    with pytest.raises(MapError, match=r"skin\.json.*one link.*link 0, link 1, link 2"):
        write_unige_map(three_patches, tmp_path / "skin.json")
