"""Small document of a tube, a sheet and a saddle, built once; edits make their own."""

from __future__ import annotations

import pytest

from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.reflatten import apply_result, reflatten, set_method
from tactile_maps.maps.build import build_map
from tests.support.surfaces import frustum, named, sheet, skin_of


@pytest.fixture(scope="session")
def document():
    return MapDocument.of(build_map(skin_of(frustum(around=16, along=6), sheet(8, 6), named("saddle"), taxels=12)))


@pytest.fixture(scope="session")
def reflattened(document):
    """The document with its sheet flattened by another method."""
    return apply_result(document, reflatten(set_method(document, [1], "tutte")))
