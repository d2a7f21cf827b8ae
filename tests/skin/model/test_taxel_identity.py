"""Identities of taxels: checked on construction, and unchanged in every skin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.calibration_error import with_calibration_error
from tactile_maps.skin.fitting.measured_taxels import place_taxels
from tactile_maps.skin.formats.taxel_files import taxel_sets
from tactile_maps.skin.model.skin import (
    LARGEST_NUMBER,
    NO_IDENTITY,
    Patch,
    Skin,
    TaxelIdentity,
    TaxelName,
    identity_summary,
    identity_text,
    join_identities,
    number_ranges,
)
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import reconstruct_skin
from tests.support.example_robots import two_rods
from tests.support.findings import only
from tests.support.surfaces import frustum, skin_of

IDS = np.array([LARGEST_NUMBER, 5, 87012, 5])


def with_ids(skin, *identities):
    pairs = zip(skin.patches, identities, strict=True)
    return Skin(tuple(replace(p, taxels=replace(p.taxels, identity=one)) for p, one in pairs))


def two_patches():
    """Two patches of four taxels; both boards have a taxel 5, the second board states no channels."""
    first = TaxelIdentity(IDS, [3, 3, 14, 14], [0, 1, 2, 3])
    return with_ids(skin_of(frustum(), frustum(), taxels=4), first, TaxelIdentity([9, 8, 7, 5], [2, 2, 2, 2]))


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"ids": [1, -1]}, "ids, row 1.*negative.*-1"),
        ({"channels": [2**31]}, "channels, row 0.*above 2147483647.*2147483648"),
        ({"ids": [1, 2], "modules": [1]}, "modules.*rows or columns"),
        ({"modules": [[1]]}, "modules.*rows or columns"),
    ],
)
def test_invalid_identities_are_rejected(fields, problem):
    with pytest.raises(SkinError, match=problem):
        TaxelIdentity(**fields)


def test_identity_of_other_taxels_is_rejected():
    taxels = skin_of(frustum(), taxels=4).patches[0].taxels
    with pytest.raises(SkinError, match="another number of taxels.*3 of 4"):
        replace(taxels, identity=TaxelIdentity([1, 2, 3]))


def test_identities_are_described_by_words_and_ranges():
    assert str(TaxelName(87012, 14, 3)) == "id 87012, module 14, channel 3"
    assert (str(TaxelName(module=0)), str(TaxelName())) == ("module 0", "")
    assert number_ranges([3, 1, 2, 9, 2, 12, 13]) == "1-3, 9, 12-13"
    assert (number_ranges([1, 3, 5, 6], most=1), number_ranges([])) == ("1 and 3 more", "")
    summary = identity_summary(TaxelIdentity(IDS, [3, 3, 14, 14]))
    assert summary["ids"] == {"different": 3, "first": 5, "last": LARGEST_NUMBER, "repeated": 1}
    assert identity_text(summary) == "ids 5 to 2147483647 (3, 1 repeated), modules 3 to 14 (2)"
    assert (identity_summary(NO_IDENTITY), identity_text({})) == ({}, "")


def test_joining_drops_ids_that_one_part_lacks():
    joined = join_identities([TaxelIdentity([1], [2], [3]), TaxelIdentity([4], None, [6])])
    assert (joined.ids.tolist(), joined.modules, joined.channels.tolist()) == ([1, 4], None, [3, 6])
    assert not join_identities([]).known
    assert not NO_IDENTITY.known


def test_taxels_are_named_and_found_by_identity():
    skin = two_patches()
    assert skin.identity.ids.tolist() == [*IDS.tolist(), 9, 8, 7, 5]
    assert (skin.identity.modules.tolist(), skin.identity.channels) == ([3, 3, 14, 14, 2, 2, 2, 2], None)
    assert (skin.taxel_name(2), skin.taxel_name(4)) == (TaxelName(87012, 14, 2), TaxelName(9, 2))
    assert skin.taxels_with_id(5).tolist() == [1, 3, 7], "ids repeat, on a board and on two"
    assert skin.taxels_with_id(6).tolist() == []
    generated = skin_of(frustum(), taxels=4)
    assert (generated.identity.known, generated.taxel_name(0)) == (False, TaxelName())
    assert generated.taxels_with_id(0).tolist() == []


def test_identity_is_kept_by_calibration_errors_and_merged_links():
    skin = two_patches()
    assert with_calibration_error(skin, 1e-3).taxels_with_id(87012).tolist() == [2]
    one_link = Skin(tuple(Patch(p.name, "arm", p.surface, p.taxels) for p in skin.patches))
    (taxels,) = taxel_sets(one_link)
    assert (taxels.numbers.tolist(), taxels.channels) == (list(range(8)), None)
    assert taxels.ids.tolist() == skin.identity.ids.tolist()


def scattered(positions):
    """Return taxels whose ids have gaps, decrease and repeat; the id of each follows from its position."""
    count = len(positions)
    ids = (LARGEST_NUMBER - 7 * np.arange(count)) % LARGEST_NUMBER
    ids[-1] = ids[0]
    return TaxelSet("s", "upper", np.arange(count), positions, ids=ids, modules=ids % 17, channels=ids % 12)


def test_identity_of_taxels_is_kept_by_reconstruction_and_merging():
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(3), indexing="ij"), -1).reshape(-1, 2) * 0.004
    flat = np.column_stack([grid, np.zeros(len(grid))])
    # The smaller piece first, so that its taxels come later in the skin; one place twice.
    taxels = scattered(np.concatenate([flat[:1], flat[:4] + [1.0, 0, 0], flat]))
    found = reconstruct_skin(taxels)
    assert len(found.skin.patches) > 1
    assert_stays_with_its_place(found.skin, taxels, 1e-12)
    merged = only(found.skin.findings, "duplicate-taxel")
    assert merged.action.endswith(f"which also receives the readings of ids {taxels.ids[5]}")
    (at,) = found.skin.taxels_with_id(int(taxels.ids[5])).tolist()
    assert found.skin.taxel_name(at).id == taxels.ids[0]
    assert identity_text(identity_summary(found.skin.identity)).endswith(", 1 aliases")


def test_identity_of_taxels_is_kept_by_fitting_to_a_link():
    angle, height = (grid.ravel() for grid in np.meshgrid(np.arange(0, 0.5, 0.15), [0.02, 0.1, 0.026, 0.106]))
    points = np.stack([0.04 * np.cos(angle), 0.04 * np.sin(angle), height], axis=1)
    taxels = scattered(points)
    skin = place_taxels(two_rods(length=0.13), "upper", taxels, file="f")
    assert (len(skin), len(skin.patches)) == (len(points), 2), "two bands, their rows by turns in the file"
    assert_stays_with_its_place(skin, taxels, 0.006)


def assert_same(one, other):
    for field in ("ids", "modules", "channels"):
        a = getattr(one, field)
        b = getattr(other, field)
        assert (a is None) == (b is None), field
        if a is not None and b is not None:
            np.testing.assert_array_equal(a, b, err_msg=field)


def assert_stays_with_its_place(skin, taxels, moved):
    """Every taxel of the skin has ids, module and channel of the taxel of the set that is nearest to it."""
    positions = np.concatenate([patch.taxels.positions for patch in skin.patches])
    away = np.linalg.norm(positions[:, None] - taxels.positions, axis=2)
    assert away.min(axis=1).max() <= moved
    assert_same(skin.identity, taxels.identity.select(away.argmin(axis=1)))
