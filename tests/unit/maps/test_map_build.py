"""From a skin to its map in one call, with a voice and a way to stop."""

from __future__ import annotations

import pytest

from app.errors import MapError
from app.maps.build import build_map
from app.skin.skin import Patch, Skin
from tests.numerics.map_surfaces import frustum, sheet, skin_of, taxels_on


def test_every_patch_gets_a_chart_in_order(three_patches):
    assert [len(chart.faces) for chart in three_patches.charts] == [
        len(patch.surface.faces) for patch in three_patches.skin.patches
    ]


def test_progress_names_the_patch_and_only_grows():
    heard = []
    build_map(skin_of(sheet(), frustum()), progress=lambda text, fraction: heard.append((text, fraction)))
    fractions = [fraction for _, fraction in heard]
    assert fractions == sorted(fractions)
    assert (fractions[0], fractions[-1]) == (0.0, 1.0)
    second = {fraction for text, fraction in heard if text == "Flattening patch 1"}
    assert second == {192 / (192 + 1440)}
    assert {text for text, _ in heard} == {"Flattening patch 0", "Flattening patch 1", "Arranging the map"}
    assert len(heard) > 10, "every round is told, so that a stop is heard soon"


def test_raising_in_progress_stops_the_work():
    class StopError(Exception):
        pass

    def stop(_text, fraction):
        if fraction > 0:
            raise StopError

    with pytest.raises(StopError):
        build_map(skin_of(sheet(), frustum()), progress=stop)


def test_the_method_reaches_every_chart():
    assert {chart.method for chart in build_map(skin_of(sheet(), sheet()), method="tutte").charts} == {"tutte"}


def test_a_skin_without_patches_is_a_named_error():
    with pytest.raises(MapError, match="no patches"):
        build_map(Skin(()))


def test_a_patch_that_cannot_be_laid_flat_is_named():
    whole = sheet()
    broken = type(whole)(whole.vertices, [*whole.faces.tolist(), [0, 10, 60]])
    skin = Skin((Patch("shin", "leg", broken, taxels_on(whole, 10)),))
    with pytest.raises(MapError, match="shin"):
        build_map(skin)
