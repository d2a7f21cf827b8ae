"""Dead, stuck, saturated and blind taxels on the map: marks and legend."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPointF
from PySide6.QtGui import QColor

from tactile_maps.editing.document import MapDocument, show_patches
from tactile_widgets.common.colours import DARK, LIGHT
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, Fault, TaxelFaults
from tests.widgets.support.samples import touched
from tests.widgets.support.snapshots import pixels

DEAD = 40
STUCK = 90


@pytest.fixture
def view(open_map_view, prepared):
    return open_map_view(700, 600, lambda view: view.show_prepared(prepared))


@pytest.fixture
def broken(prepared):
    kinds = np.zeros(len(prepared.skin), np.int8)
    kinds[DEAD] = 1
    kinds[STUCK] = 2
    return TaxelFaults(kinds, 9e3)


def around(view, prepared, taxel):
    """(h, w, 3) the pixels of a taxel's mark."""
    at = view.pixel_of(prepared.skin.taxel_point(taxel)) - QPointF(9, 9)
    image = pixels(view.viewport().grab().toImage())
    x = round(at.x())
    y = round(at.y())
    return image[y : y + 19, x : x + 19]


def near(image, colour):
    """Find out if some pixel has about this colour."""
    return bool((np.abs(image - np.array(QColor(colour).toTuple()[:3])).max(axis=2) < 40).any())


def test_only_broken_taxels_are_marked(view, prepared, broken):
    whole = {taxel: around(view, prepared, taxel) for taxel in (DEAD, STUCK, 10)}
    view.set_faults(broken)
    for taxel in (DEAD, STUCK):
        assert near(around(view, prepared, taxel), "#1d2126"), "a dark mark on light skin"
        assert not near(whole[taxel], "#1d2126")
    np.testing.assert_array_equal(around(view, prepared, 10), whole[10])
    view.set_faults(NO_FAULTS)
    np.testing.assert_array_equal(around(view, prepared, DEAD), whole[DEAD])


def test_taxel_is_hatched_while_it_is_saturated(view, prepared, broken):
    pressures = np.zeros(len(prepared.skin))
    pressures[10] = 9e3
    view.set_faults(broken)
    assert Fault.SATURATED not in dict(view.marks.faults)
    view.show_frame(replace(touched(prepared.map), pressures=pressures))
    assert dict(view.marks.faults)[Fault.SATURATED] == "1 taxel saturated"
    assert near(around(view, prepared, 10), "#ffffff")
    view.show_frame(replace(touched(prepared.map), pressures=0 * pressures))
    assert Fault.SATURATED not in dict(view.marks.faults)


def test_marks_are_hidden_with_their_patch(view, prepared, broken):
    view.set_faults(broken)
    document = MapDocument.of(prepared.map)
    patch = int(np.searchsorted(prepared.skin.first, DEAD, side="right")) - 1
    view.show_document(show_patches(document, [patch], visible=False))
    assert not near(around(view, prepared, DEAD), "#ffffff")
    view.show_document(document)
    assert near(around(view, prepared, DEAD), "#1d2126")


@pytest.mark.parametrize("theme", [DARK, LIGHT])
def test_blind_areas_are_hatched_on_the_map_and_named(view, prepared, theme):
    view.set_theme(theme)
    whole = around(view, prepared, DEAD)
    faults = around_blind(prepared)
    view.set_faults(faults)
    hatched = around(view, prepared, DEAD)
    view.set_faults(replace(faults, blind=()))
    crossed = around(view, prepared, DEAD)
    assert ink(hatched) > ink(crossed) > ink(whole)
    assert Fault.BLIND not in dict(view.marks.faults)
    view.set_faults(faults)
    count = sum(len(area.taxels) for area in faults.blind)
    assert dict(view.marks.faults)[Fault.BLIND] == f"{count} taxel{'s' * (count > 1)} blind"
    words = view.words_for(prepared.skin.taxel_point(DEAD))
    assert "dead, blind: too few working neighbours" in words
    view.set_faults(NO_FAULTS)
    np.testing.assert_array_equal(around(view, prepared, DEAD), whole)


def around_blind(prepared):
    """A dead taxel among dead ones."""
    pairs = prepared.skin.neighbours
    kinds = np.zeros(len(prepared.skin), np.int8)
    kinds[np.unique(pairs[(pairs == DEAD).any(axis=1)])] = 1
    return TaxelFaults(kinds).with_areas(prepared.skin, estimated=True)


def ink(image):
    """Number of pixels as dark as a mark."""
    return int((np.abs(image - np.array(QColor("#1d2126").toTuple()[:3])).max(axis=2) < 40).sum())
