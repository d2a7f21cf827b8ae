"""A map of two bodies with known theory: a tube, which flattens without distortion, and a hemisphere, which cannot."""

from __future__ import annotations

import pytest

from tactile_maps.maps.build import build_map
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tactile_maps.studies.study.work_precision import Subject
from tactile_maps.studies.testbeds.reference_bodies import MESHES


@pytest.fixture(scope="session")
def bodies():
    """Return both patches with their initial maps."""
    patches = []
    for name in ("tube", "hemisphere"):
        surface = MESHES[name](600)
        patches.append(Patch(name, name, surface, place_evenly(surface, 60, seed=0)))
    return build_map(Skin(tuple(patches)))


@pytest.fixture(scope="session")
def tube(bodies):
    return Subject.of(bodies, (0,))


@pytest.fixture(scope="session")
def hemisphere(bodies):
    return Subject.of(bodies, (1,))
