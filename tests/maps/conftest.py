"""Small map of three different patches, built once."""

from __future__ import annotations

import pytest

from tactile_maps.maps.build import build_map
from tests.support.surfaces import frustum, named, skin_of


@pytest.fixture(scope="session")
def three_patches():
    """A tube, a saddle and a hemisphere, each with 40 taxels."""
    return build_map(skin_of(frustum(along=16, around=30), named("saddle"), named("hemisphere")))
