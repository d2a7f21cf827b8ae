"""A taxel is found by what the robot or the program calls it, and what is not there is said with what is."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.model.skin import Skin, TaxelIdentity
from tactile_widgets.document.taxel_search import find_taxels, taxel_words
from tests.support.surfaces import frustum, skin_of

BARE = skin_of(frustum(along=5, around=8), frustum(along=5, around=8), taxels=4)
_IDENTITIES = (TaxelIdentity([87012, 86999, 2, 2**31 - 1], [14, 14, 3, 3], [3, 0, 1, 1]), TaxelIdentity([2, 5, 6, 9]))
KNOWN = Skin(
    tuple(
        replace(patch, taxels=replace(patch.taxels, identity=identity))
        for patch, identity in zip(BARE.patches, _IDENTITIES, strict=True)
    )
)


@pytest.mark.parametrize(
    ("text", "taxels", "words"),
    [
        ("87012", [0], "id 87012, module 14, channel 3 (taxel 0)"),
        (" 2147483647 ", [3], "id 2147483647, module 3, channel 1 (taxel 3)"),
        ("2", [2, 4], "2 taxels, first id 2, module 3, channel 1 (taxel 2)"),
        ("link 1:2", [4], "id 2 (taxel 4)"),
        ("#2", [2], "id 2, module 3, channel 1 (taxel 2)"),
        ("7", [7], "id 9 (taxel 7)"),
        ("14/3", [0], "id 87012, module 14, channel 3 (taxel 0)"),
        ("3 / 1", [2, 3], "2 taxels, first id 2, module 3, channel 1 (taxel 2)"),
        ("14/", [0, 1], "2 taxels, first id 87012, module 14, channel 3 (taxel 0)"),
    ],
)
def test_existing_taxels_are_found(text: str, taxels: list[int], words: str) -> None:
    found = find_taxels(KNOWN, text)
    assert (found.taxels.tolist(), found.words) == (taxels, words)


@pytest.mark.parametrize(
    ("skin", "text", "said"),
    [
        (KNOWN, "#8", "unknown taxel.*#8.*taxels 0 to 7, ids 2 to 2147483647"),
        (KNOWN, "87013", "unknown taxel.*87013"),
        (KNOWN, "14/9", "unknown taxel.*14/9"),
        (KNOWN, "link 1:86999", "invalid name of a taxel.*link 1:86999.*l_hand:12 for an id on a link"),
        (BARE, "14/3", "unknown taxel.*14/3.*states no ids"),
        (BARE, "8", "unknown taxel.*8.*taxels 0 to 7"),
        (BARE, "thumb", "invalid name of a taxel.*thumb.*87012 for an id"),
        (BARE, "", "invalid name of a taxel.*nothing"),
        (BARE, "-1", "invalid name of a taxel.*-1"),
        (BARE, "99999999999", "invalid name of a taxel"),
    ],
)
def test_unknown_taxels_are_rejected(skin: Skin, text: str, said: str) -> None:
    with pytest.raises(SkinError, match=said):
        find_taxels(skin, text)


def test_skin_without_ids_is_searched_by_number() -> None:
    assert find_taxels(BARE, "3").taxels.tolist() == [3]
    assert taxel_words(BARE, 3) == "taxel 3"
