"""Layout files written here with each defect, and the real ones where they are at hand."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.skin.formats.icub.layout import (
    IcubLayout,
    LayoutModule,
    apply_layout,
    read_icub_layout,
)
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.formats.icub.sensor_kinds import TRIANGLE
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_taxels import strip
from tests.support.findings import kinds
from tests.support.real_icub import LAYOUTS, POSITIONS, needs_files

HEAD = "cardid 8 9\nrobotPart left_arm\nwidth 500\t\n\n[SENSORS]\t\n# Number X Y\n"


def written(tmp_path, text):
    path = tmp_path / "left_part.ini"
    path.write_text(text)
    return path


def test_module_is_mirrored_then_rotated_then_translated(tmp_path):
    layout = read_icub_layout(written(tmp_path, HEAD + "triangle_10pad 5 10 20 90 5 1\n"))
    x, y = TRIANGLE.pads[1]
    np.testing.assert_allclose(layout.points[1], [0.010 - y, 0.020 - x], atol=1e-12)
    np.testing.assert_array_equal(layout.numbers, np.arange(60, 72))
    np.testing.assert_allclose(layout.points[3], [0.010, 0.020], atol=1e-12)


def test_mirror_and_layout_number_are_optional(tmp_path):
    text = HEAD + "triangle_10pad 2 0 0 0 5\ntriangle_10pad 1 9 0 0 5 0 3\n"
    layout = read_icub_layout(written(tmp_path, text))
    assert [module.number for module in layout.modules] == [2, 1]
    assert layout.numbers.tolist() == list(range(12, 36))
    np.testing.assert_allclose(layout.points[3], [0.009, 0], atol=1e-15)


def test_repeated_and_unknown_modules_are_counted(tmp_path):
    lines = ["triangle_10pad 4 1 2 30 5 1"] * 3 + ["triangle_10pad 4 1 2 90 5 1", "ear 9 0 0 0 5", "tongue 1 0 0 0 5"]
    layout = read_icub_layout(written(tmp_path, HEAD + "\n".join([*lines, "tongue 2 0 0 0 5"])))
    assert len(layout.modules) == 1
    assert np.rad2deg(layout.modules[0].angle) == pytest.approx(30)
    assert [(f.kind, f.count) for f in layout.findings] == [
        ("unknown-sensor-kind", 1),
        ("unknown-sensor-kind", 2),
        ("repeated-module", 2),
        ("conflicting-module", 1),
    ]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("triangle_10pad 1 2 3", "line 7.*5 to 7 numbers.*1 2 3"),
        ("triangle_10pad 1 2 3 4 5 0 1 9", "line 7.*5 to 7"),
        ("triangle_10pad 1 2 x 4 5", "line 7.*must be numbers.*x"),
        ("triangle_10pad 1 2 nan 4 5", "line 7.*not finite"),
        ("triangle_10pad -1 2 3 4 5", "line 7.*whole, from 0.*-1"),
        ("triangle_10pad 1.5 2 3 4 5", "line 7.*whole"),
        ("triangle_10pad 99999 2 3 4 5", "line 7.*whole"),
        ("triangle_10pad 1 2 3e9 4 5", "line 7.*implausibly large"),
        ("triangle_10pad 1 2 3 4 5 7", "line 7.*mirror must be 0 or 1"),
        ("toe 1 2 3 4 5", "no module of a known kind.*toe.*triangle_10pad, triangle, fingertip"),
        ("", "no module of a known kind"),
    ],
)
def test_invalid_lines_are_rejected_with_line_and_value(tmp_path, line, problem):
    with pytest.raises(SkinError, match=rf"left_part\.ini.*{problem}"):
        read_icub_layout(written(tmp_path, HEAD + line))


def test_taxels_are_matched_to_their_map_points_by_number():
    taxels, layout = strip(4)
    mixed = taxels.select(np.arange(len(taxels)) != 5)
    mixed = TaxelSet("strip", None, mixed.numbers[::-1], mixed.positions[::-1])
    joined = apply_layout(mixed, layout)
    place = np.searchsorted(layout.numbers, mixed.numbers)
    np.testing.assert_array_equal(joined.points, layout.points[place])
    np.testing.assert_array_equal(joined.modules, mixed.numbers // 12)
    assert kinds(joined.findings) == {"layout-without-taxel": 1}


def test_taxels_missing_on_the_map_have_no_place_and_are_counted():
    taxels, layout = strip(4)
    joined = apply_layout(taxels, IcubLayout("half", layout.modules[:2]))
    assert kinds(joined.findings) == {"not-on-layout": 20}
    np.testing.assert_array_equal(joined.mapped, joined.modules < 4)
    with pytest.raises(SkinError, match=r"shows none of these taxels.*\[77\].*same patch as strip"):
        apply_layout(taxels, IcubLayout("other", (LayoutModule(77, 0, 0, 0),)))


@needs_files
@pytest.mark.parametrize(
    ("positions", "layout", "modules", "without"),
    [("left_arm", "left_arm_V2_7", 35, 0), ("left_forearm_V2", "left_forearm_V2", 24, 92), ("torso", "torso", 44, 67)],
)
def test_real_layouts_fit_their_positions(positions, layout, modules, without):
    drawn = read_icub_layout(LAYOUTS / f"{layout}.ini")
    assert (len(drawn.modules), drawn.findings) == (modules, ())
    joined = apply_layout(read_icub_positions(POSITIONS / f"{positions}.txt"), drawn)
    assert joined.mapped.all()
    assert kinds(joined.findings).get("layout-without-taxel", 0) == without
    inside = joined.modules[:, None] == joined.modules
    true = np.linalg.norm(joined.positions[:, None] - joined.positions, axis=2)
    flat = np.linalg.norm(joined.points[:, None] - joined.points, axis=2)
    near = inside & (true > 0) & (true < 0.008)
    assert np.median(flat[near] / true[near]) == pytest.approx(0.98, abs=0.04)
