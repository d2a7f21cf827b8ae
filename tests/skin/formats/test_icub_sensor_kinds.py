"""Pads of every kind of iCub's modules: counts, spacing, mirror images; layouts with them, and the real ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import cdist, pdist

from tactile_maps.skin.formats.icub.layout import apply_layout, read_icub_layout
from tactile_maps.skin.formats.icub.module_orientation import propose_orientations
from tactile_maps.skin.formats.icub.sensor_kinds import KINDS
from tactile_maps.skin.formats.taxel_files import read_taxels, write_taxels
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_taxels import write_icub_layout
from tests.support.findings import kinds
from tests.support.real_icub import LAYOUTS, needs_files

HAND = "".join(f"fingertip2L {k} {16 * k} 35 {10 * k} 4 0 0\n" for k in range(5)) + "palmL 8 -25 0 0 4 0 0\n"


def layout_of(tmp_path, lines):
    (tmp_path / "part.ini").write_text("cardid 14\n[SENSORS]\n" + lines)
    return read_icub_layout(tmp_path / "part.ini")


@pytest.mark.parametrize("name", KINDS)
def test_pads_are_distinct_and_within_a_few_centimetres(name):
    kind = KINDS[name]
    placed = np.isfinite(kind.pads[:, 0])
    assert len(kind.pads) % 12 == 0 or name == "quad16"
    assert 0.0024 < pdist(kind.pads[placed]).min() < 0.009
    assert pdist(kind.pads[placed]).max() < 0.1
    assert kind.felt.sum() == placed.sum() - len(kind.thermal)


def test_left_and_right_hands_are_equal_or_mirror_images():
    for left, right, side in (
        ("palmL", "palmR", 1),
        ("fingertip2L", "fingertip2R", -1),
        ("fingertip3L", "fingertip3R", 1),
    ):
        one = KINDS[left].pads
        other = KINDS[right].pads * [side, 1]
        assert cdist(one, other).min(axis=0).max() < 1e-9
        assert cdist(one, other).min(axis=1).max() < 1e-9
    left_pads, right_pads = (KINDS[f"cer_sh_pd{side}"].pads for side in "lr")
    np.testing.assert_allclose(left_pads * [-1, 1] + [0.0484, 0], right_pads, atol=1e-9)


def test_triangles_are_symmetric_under_rotation_by_120_degrees():
    for name in ("triangle", "triangle_10pad"):
        points = KINDS[name].pads[KINDS[name].felt] @ [1, 1j]
        turned = points * np.exp(2j * np.pi / 3)
        assert np.abs(turned[:, None] - points).min(axis=1).max() < 2e-5


def test_palm_counts_as_four_boards_and_later_numbers_are_shifted(tmp_path):
    layout = layout_of(tmp_path, HAND + "fingertip 9 0 0 0 4\n")
    assert layout.starts == {0: 0, 1: 12, 2: 24, 3: 36, 4: 48, 8: 96, 9: 144}
    assert layout.numbers.tolist() == [*range(60), *range(96, 156)]
    assert layout.numbers[~layout.felt].tolist() == [107, 119, 131, 139]


def test_channels_without_a_pad_are_not_shown(tmp_path):
    layout = layout_of(tmp_path, "cer_sh_tp 8 51 -1 270 4 0 0\ncer_sh_pdr 0 0 9 0 4 0 0\n")
    assert layout.starts == {0: 0, 8: 120}
    assert layout.numbers.tolist() == [*range(11), *range(12, 23), *range(24, 29), *range(120, 130)]
    assert np.isfinite(layout.points).all()


def test_layout_number_one_reverses_the_order_and_some_kinds_are_not_mirrored(tmp_path):
    plain = layout_of(tmp_path, "fingertip 0 5 0 0 4 1 0\n")
    backwards = layout_of(tmp_path, "fingertip 0 5 0 0 4 1 1\n")
    np.testing.assert_array_equal(backwards.points, plain.points[::-1])
    for name, same in (("fingertip", False), ("fingertip2R", True), ("palmR", False)):
        one, other = (layout_of(tmp_path, f"{name} 0 5 0 0 4 {mirror} 0\n").points for mirror in (0, 1))
        assert np.array_equal(one, other) == same
        if not same:
            np.testing.assert_allclose(other, [0.010, 0] - one * [1, -1], atol=1e-12)


@pytest.mark.parametrize("ending", [".ini", ".json", ".csv", ".npz"])
def test_hand_keeps_its_ids_and_positions_in_every_format(tmp_path, ending):
    layout = layout_of(tmp_path, HAND)
    if ending == ".ini":
        write_icub_layout(layout, tmp_path / "back.ini")
        back = read_icub_layout(tmp_path / "back.ini")
        np.testing.assert_array_equal(back.numbers, layout.numbers)
        np.testing.assert_allclose(back.points, layout.points, atol=1e-11)
        return
    places = np.concatenate([layout.points, np.zeros((len(layout.points), 1))], axis=1)
    hand = TaxelSet("hand", "l_hand", np.arange(len(places)), places, ids=layout.numbers).select(layout.felt)
    write_taxels(apply_layout(hand, layout), tmp_path / f"hand{ending}")
    back = read_taxels(tmp_path / f"hand{ending}")
    assert back.ids is not None
    assert back.ids.tolist() == layout.numbers[layout.felt].tolist()
    np.testing.assert_array_equal(back.modules, back.ids // 12)
    again = apply_layout(back, layout)
    assert again.mapped.all()
    assert not any(finding.kind == "layout-without-taxel" for finding in again.findings)


def test_only_triangles_are_checked_for_rotation(tmp_path):
    layout = layout_of(tmp_path, HAND)
    places = np.concatenate([layout.points, np.zeros((len(layout.points), 1))], axis=1)
    hand = TaxelSet("hand", "l_hand", np.arange(len(places)), places, ids=layout.numbers)
    assert len(propose_orientations(hand, layout).modules) == 0
    mixed = layout_of(tmp_path, "palmL 8 90 0 0 4 0 0\n" + "".join(f"triangle {k} {30 * k} 0 0 4\n" for k in range(3)))
    places = np.concatenate([mixed.points, np.zeros((len(mixed.points), 1))], axis=1)
    both = TaxelSet("both", None, np.arange(len(places)), places, ids=mixed.numbers)
    assert propose_orientations(both, mixed).modules.tolist() == [0, 1, 2]


@needs_files
def test_every_real_layout_is_read_completely():
    """Against another count of the same files: their lines, each with as many pads as its kind has."""
    files = sorted(LAYOUTS.glob("*.ini"))
    assert len(files) == 49
    for file in files:
        layout = read_icub_layout(file)
        assert "unknown-sensor-kind" not in kinds(layout.findings)
        lines = [line.split() for line in file.read_text().partition("[SENSORS]")[2].splitlines()]
        named = {int(words[1]): words[0] for words in reversed(lines) if words and words[0][0] not in "#/"}
        addresses = []
        ahead = 0
        for slot in range(max(named) + 1):
            pads = KINDS[named[slot]].pads if slot in named else np.full((12, 2), np.nan)
            addresses += [ahead + k for k in range(len(pads)) if np.isfinite(pads[k, 0])]
            ahead += len(pads)
        assert layout.numbers.tolist() == addresses, file.name
