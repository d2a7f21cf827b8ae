"""Values go to the taxels that their labels name; what no taxel has is named and counted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.channels.matching import TaxelMatcher, load_matching
from tactile_maps.live.readings.readings import MalformedReadingError, Reading
from tactile_maps.live.readings.tables import read_rows
from tactile_maps.skin.model.skin import Patch, Skin, TaxelIdentity
from tests.support.touch import bar_skin


def skin(**identity):
    """The bar's skin with such an identity."""
    (patch,) = bar_skin().patches
    return Skin((replace(patch, taxels=replace(patch.taxels, identity=TaxelIdentity(**identity))),))


IDS = 1000 + 7 * np.arange(60)


def test_readings_are_matched_by_id_in_any_order():
    taxels, values = TaxelMatcher(skin(ids=IDS)).match(Reading(0.0, [5.0, 6.0], ids=[IDS[9], IDS[2]]))
    assert dict(zip(taxels, values, strict=True)) == {9: 5.0, 2: 6.0}


def test_nan_marks_taxels_that_did_not_report():
    matcher = TaxelMatcher(skin(ids=IDS))
    by_id = Reading(0.0, [np.nan, 6.0], ids=[IDS[9], IDS[2]])
    in_order = Reading(0.0, np.where(np.arange(60) == 4, np.nan, 1.0))
    assert [found.tolist() for found in matcher.match(by_id)] == [[2], [6.0]]
    assert matcher.heard.sum() == 1
    assert matcher.taxels(in_order).tolist() == [taxel for taxel in range(60) if taxel != 4]
    assert matcher.match(in_order)[1].tolist() == [1.0] * 59


def test_unknown_ids_are_named_and_counted_each_time():
    matcher = TaxelMatcher(skin(ids=IDS))
    for _ in range(3):
        taxels, _values = matcher.match(Reading(0.0, [5.0, 6.0, 7.0], ids=[IDS[9], 1, 2]))
    assert taxels.tolist() == [9]
    assert matcher.unknown == {"1", "2"}
    assert matcher.unknown_values == 6
    assert matcher.heard.sum() == 1


def test_id_shared_by_two_taxels_matches_neither():
    matcher = TaxelMatcher(skin(ids=[7, 7, *range(100, 158)]))
    taxels, _ = matcher.match(Reading(0.0, [5.0, 6.0], ids=[7, 100]))
    assert taxels.tolist() == [2]
    assert (matcher.unknown, matcher.ambiguous, matcher.ambiguous_values) == (set(), {"7 (of several taxels)"}, 1)


def two_links():
    """The bar's skin on two links that repeat the ids 0 to 59."""
    (patch,) = bar_skin().patches
    taxels = replace(patch.taxels, identity=TaxelIdentity(ids=np.arange(60)))
    return Skin((Patch("a", "left", patch.surface, taxels), Patch("b", "right", patch.surface, taxels)))


def test_id_on_two_links_is_addressed_with_its_link():
    matcher = TaxelMatcher(two_links())
    taxels, values = matcher.match(Reading(0.0, [5.0, 6.0, 7.0], ids=[3, 3, 99], links=("right", "left", "left")))
    assert dict(zip(taxels, values, strict=True)) == {63: 5.0, 3: 6.0}
    assert matcher.unknown == {"left:99"}
    matcher.match(Reading(0.0, [5.0], ids=[3]))
    assert matcher.ambiguous == {"3 (left:3 or right:3)"}


@pytest.mark.parametrize(("readings", "shown"), [([2.0, 9.0, 4.0], 9.0), ([2.0, -1.0, -3.0], 2.0)])
def test_taxel_with_aliases_shows_the_largest_of_their_values(readings, shown):
    matcher = TaxelMatcher(skin(ids=IDS, aliases=[[5, 9], [6, 9]]))
    taxels, values = matcher.match(Reading(0.0, [1.0, *readings], ids=[IDS[2], IDS[9], 5, 6]))
    assert dict(zip(taxels, values, strict=True)) == {2: 1.0, 9: shown}
    assert matcher.heard.sum() == 2


def test_taxel_with_aliases_shows_the_smallest_value_if_values_decrease_under_pressure():
    matcher = TaxelMatcher(skin(ids=IDS, aliases=[[5, 9], [6, 2]]))
    falls = np.arange(60) == 9
    reading = Reading(0.0, [4.0, 3.0, np.nan, 2.0, 8.0], ids=[IDS[9], 5, 77, IDS[2], 6])
    taxels, values = matcher.match(reading, falls)
    assert dict(zip(taxels, values, strict=True)) == {9: 3.0, 2: 8.0}
    assert dict(zip(*matcher.match(reading), strict=True)) == {9: 4.0, 2: 8.0}


def test_stream_of_all_channels_has_the_value_of_each_id():
    ids = np.arange(0, 120, 2)
    matcher = TaxelMatcher(skin(ids=ids, aliases=[[7, 3]], stream=128))
    taxels, values = matcher.match(Reading(0.0, np.arange(128.0)))
    assert dict(zip(taxels, values, strict=True)) == {
        taxel: max(2.0 * taxel, 7.0 * (taxel == 3)) for taxel in range(60)
    }
    matcher.match(Reading(0.0, [1.0, 2.0], ids=[9, 130]))
    assert matcher.unknown == {"130"}, "channel 9 has no taxel, such as a thermal pad"
    with pytest.raises(MalformedReadingError, match="127 values for 60 taxels"):
        matcher.match(Reading(0.0, np.arange(127.0)))


def test_stream_that_fits_two_links_is_rejected_with_their_names():
    parts = [
        replace(p, taxels=replace(p.taxels, identity=replace(p.taxels.identity, stream=64)))
        for p in two_links().patches
    ]
    with pytest.raises(MalformedReadingError, match=r"link:id\): left, right have such a stream"):
        TaxelMatcher(Skin(tuple(parts))).match(Reading(0.0, np.zeros(64)))


def test_table_of_ids_may_name_taxels_by_link_and_id(tmp_path):
    path = tmp_path / "ids.csv"
    path.write_text("id,taxel\n500,right:3\n")
    assert load_matching(path, two_links()) == {500: 63}
    path.write_text("id,taxel\n500,middle:3\n")
    with pytest.raises(LiveError, match="line 2: unknown taxel .found: middle:3"):
        load_matching(path, two_links())


def test_readings_are_matched_by_module_and_channel():
    matcher = TaxelMatcher(skin(modules=np.arange(60) // 12, channels=np.arange(60) % 12))
    taxels, _ = matcher.match(Reading(0.0, [1.0, 2.0], channels=[[2, 3], [9, 0]]))
    assert taxels.tolist() == [27]
    assert matcher.unknown == {"module 9, channel 0"}


def test_readings_without_labels_must_have_all_taxels_in_order():
    matcher = TaxelMatcher(bar_skin())
    taxels, values = matcher.match(Reading(0.0, np.arange(60.0)))
    assert np.array_equal(taxels, np.arange(60))
    assert values[7] == 7.0
    with pytest.raises(MalformedReadingError, match="59 values for 60 taxels"):
        matcher.match(Reading(0.0, np.arange(59.0)))


def test_skin_without_ids_is_matched_by_taxel_numbers():
    assert TaxelMatcher(bar_skin()).match(Reading(0.0, [1.0], ids=[12]))[0].tolist() == [12]


def test_table_maps_stream_ids_to_taxels(tmp_path):
    path = tmp_path / "ids.csv"
    path.write_text("# of our boards\nid,taxel\n500,3\n501,4\n")
    matcher = TaxelMatcher(skin(ids=IDS), load_matching(path, bar_skin()))
    assert matcher.match(Reading(0.0, [1.0, 2.0], ids=[501, IDS[9]]))[0].tolist() == [4]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "empty"),
        ("id\n3\n", "column is missing: taxel .found: id"),
        ("id,taxel\n3\n", "line 2: a row does not fit"),
        ("id,taxel\n3,60\n", "line 2: unknown taxel"),
        ("id,taxel\n3,x\n", "line 2, taxel: expected a whole number"),
        (f"id,taxel\n{2**64},1\n", "line 2, id: expected a whole number.*at most 18 digits"),
        (f"id,taxel\n{'9' * 5000},1\n", "line 2, id: expected a whole number.*at most 18 digits"),
        ("id,taxel\n3,1\n\n3,2\n", "line 4: an id is assigned to two taxels"),
    ],
)
def test_invalid_table_entry_is_reported(tmp_path, text, said):
    path = tmp_path / "ids.csv"
    path.write_text(text)
    with pytest.raises(LiveError, match=said):
        load_matching(path, bar_skin())


def test_rows_have_their_line_numbers(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("# a remark\nA, b\n\n1, 2\n")
    assert read_rows(path, ("a",)) == [(4, {"a": "1", "b": "2"})]
