"""Random surfaces, zones and numbers: what holds for every placement, and for every cloud of taxels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from tactile_maps.core.errors import SkinError
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import reconstruct_skin
from tactile_maps.skin.taxel_placement.placement import (
    PlacementSpec,
    SphereZone,
    allowed_faces,
    place_taxels,
    refine_for_spec,
)
from tests.support.examples import examples
from tests.support.surfaces import frustum, sheet

SURFACES = (
    sheet(shape=lambda x, y: 4 * x * y),
    frustum(around=18, along=8, length=0.08),
    frustum(0.03, 0.01, around=14, along=6, length=0.05),
)


@examples(30)
@given(
    surface=st.sampled_from(SURFACES),
    taxels=st.integers(1, 60),
    pattern=st.sampled_from(["even", "hexagonal"]),
    centre=hnp.arrays(float, 3, elements=st.floats(-0.05, 0.1)),
    radius=st.floats(1e-3, 0.04),
    seed=st.integers(0, 9),
)
def test_placement_has_the_requested_number_and_covers_exactly_the_allowed_surface(
    surface, taxels, pattern, centre, radius, seed
):
    zone = SphereZone(centre, radius)
    requested = PlacementSpec(taxels=taxels, pattern=pattern, keep_out=(zone,), seed=seed)
    try:
        fine, spec = refine_for_spec(surface, requested)
    except SkinError:
        assume(False)  # the ball swallows it all
    allowed = allowed_faces(fine.mesh, (zone,))
    placed = place_taxels(fine.mesh, spec)
    assert len(placed) == taxels
    assert np.isclose(placed.areas.sum(), fine.mesh.face_areas[allowed].sum(), rtol=1e-12)
    assert placed.areas.min() > 0
    assert allowed[placed.faces].all()
    assert (np.linalg.norm(placed.positions - centre, axis=1) > radius).all()
    assert np.allclose(np.linalg.norm(placed.normals, axis=1), 1)


places = hnp.arrays(
    float,
    st.tuples(st.integers(1, 40), st.just(3)),
    elements=st.integers(-6, 6).map(lambda k: 0.004 * k),  # many coincide, and many are in rows and planes
)


@pytest.mark.long
@examples(60)
@given(places=places, flat=st.integers(0, 2), jitter=st.sampled_from([0.0, 1e-7, 1e-4]), seed=st.integers(0, 99))
def test_any_point_cloud_becomes_a_skin_with_every_taxel(places, flat, jitter, seed):
    points = places * (np.arange(3) >= flat) + jitter * np.random.default_rng(seed).normal(size=places.shape)
    built = reconstruct_skin(TaxelSet("cloud", None, np.arange(len(points)), points))
    at = np.concatenate([patch.taxels.positions for patch in built.skin.patches])
    assert np.abs(at[built.taxel_of] - points).max() < 1e-4
    assert len(built.skin) == len(np.unique(built.taxel_of))
    for patch in built.skin.patches:
        faces = patch.surface.faces
        assert Connectivity(faces).face_count.max() <= 2
        assert not len(Connectivity(faces).bow_tie_vertices)
        assert Connectivity(faces).components.max() == 0
        assert patch.taxels.areas.min() > 0
        assert np.isclose(patch.taxels.areas.sum(), patch.surface.area)
        assert np.isfinite(patch.taxels.normals).all()
