from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.formats.svg import MARGIN, svg, write_svg
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Skin

SVG = "{http://www.w3.org/2000/svg}"


def numbers_in(text):
    return np.array(re.findall(r"-?\d+\.\d+", text), dtype=float).reshape(-1, 2)


def test_everything_is_on_the_page_at_its_true_size(three_patches):
    root = ElementTree.fromstring(svg(three_patches))
    width, height = (float(root.get(side).removesuffix("mm")) for side in ("width", "height"))
    np.testing.assert_allclose([width, height], 1e3 * np.ptp(three_patches.bounds, axis=0) + 2 * MARGIN, atol=1e-3)
    assert root.get("viewBox") == f"0 0 {width:.3f} {height:.3f}"
    groups = [group for group in root.findall(f"{SVG}g") if group.get("class") == "patch"]
    assert len(groups) == 3
    for k, group in enumerate(groups):
        outline = numbers_in(group.find(f"{SVG}path").get("d"))
        assert ((outline >= MARGIN - 1e-3) & (outline <= np.array([width, height]) - MARGIN + 1e-3)).all()
        sides = [
            np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1) for loop in (outline, three_patches.outlines[k])
        ]
        np.testing.assert_allclose(sides[0], 1e3 * sides[1], atol=3e-3)
        seams = group.find(f"{SVG}g[@id='seams-{k}']/{SVG}path")
        assert (seams is not None) == (len(three_patches.seams[k]) > 0)
    assert len(three_patches.seams[0]) > 0


def test_map_is_upright_on_the_page_and_taxels_are_numbered_consecutively(three_patches):
    root = ElementTree.fromstring(svg(three_patches))
    circles = {c.get("id"): (float(c.get("cx")), float(c.get("cy"))) for c in root.iter(f"{SVG}circle")}
    assert len(circles) == len(three_patches.skin)
    drawn = np.array([circles[f"taxel-{n}"] for n in range(len(three_patches.skin))])
    low, high = 1e3 * three_patches.bounds
    expected = 1e3 * three_patches.taxel_points
    np.testing.assert_allclose(
        drawn - MARGIN, np.stack([expected[:, 0] - low[0], high[1] - expected[:, 1]], axis=1), atol=1e-3
    )
    texts = [text.text for text in root.iter(f"{SVG}text") if text.get("class") == "number"]
    assert texts == [str(n) for n in range(len(three_patches.skin))]
    bare = ElementTree.fromstring(svg(three_patches, numbers=False))
    assert not [text for text in bare.iter(f"{SVG}text") if text.get("class") == "number"]


def test_any_patch_name_gives_a_valid_file(three_patches, tmp_path):
    names = ['<b>&"quoted"', "control \x07\ud800", "ümläut 手"]
    patches = [replace(patch, name=name) for patch, name in zip(three_patches.skin.patches, names, strict=True)]
    write_svg(TactileMap(Skin(tuple(patches)), three_patches.charts, three_patches.layout), tmp_path / "map.svg")
    root = ElementTree.parse(tmp_path / "map.svg").getroot()
    assert [t.text for t in root.iter(f"{SVG}text") if t.get("class") == "name"] == [names[0], "control ", names[2]]
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert len(set(ids)) == len(ids)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9-]*", name) for name in ids)


def test_same_map_gives_the_same_bytes_and_missing_folder_is_named(three_patches, tmp_path):
    assert svg(three_patches) == svg(three_patches)
    with pytest.raises(MapError, match="cannot be written"):
        write_svg(three_patches, tmp_path / "no" / "map.svg")
