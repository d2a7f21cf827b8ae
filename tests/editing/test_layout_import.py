"""Import of another layout of the same skin: rejected, copied in full, or followed by pins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.editing.arrange import mirror, move, rotate
from tactile_maps.editing.document import MapDocument, rename_patch
from tactile_maps.editing.document_file import document_from_bytes, document_to_bytes, save_document
from tactile_maps.editing.layout_import import (
    adopt_document,
    arrange_as_drawn,
    drawing_from_taxels,
    is_drawn_so,
    pin_as_drawn,
    place_as_drawn,
    points_on_other_map,
    read_other_layout,
    same_skin,
)
from tactile_maps.editing.reflatten import apply_result, reflatten
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.comparison import TaxelLayout, procrustes
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.maps.formats.svg import read_svg_taxels, write_svg
from tactile_maps.skin.formats.icub.layout import IcubLayout, LayoutModule
from tactile_maps.skin.formats.taxel_files import taxel_sets, write_taxels
from tactile_maps.skin.model.skin import Skin
from tactile_maps.skin.model.taxel_set import TaxelSet
from tests.support.example_taxels import write_icub_layout
from tests.support.surfaces import sheet, skin_of


def _skin_with(skin, number, **changed):
    patches = list(skin.patches)
    patches[number] = replace(patches[number], **changed)
    return Skin(tuple(patches))


def test_saved_skin_with_renamed_patches_is_recognized_as_the_same_skin(document):
    loaded = document_from_bytes(document_to_bytes(document)).skin
    assert loaded is not document.skin
    assert same_skin(document.skin, loaded)
    assert same_skin(document.skin, _skin_with(document.skin, 0, name="other"))


def test_drawing_edited_in_another_program_places_the_patches(document, tmp_path):
    path = tmp_path / "map.svg"
    write_svg(document.map, path)
    drawing, placed = read_svg_taxels(path)
    assert placed
    assert place_as_drawn(document, drawing) is document
    assert is_drawn_so(document, drawing)
    group = 'class="patch" id="patch-1"'
    text = path.read_text()
    assert group in text
    path.write_text(text.replace(group, f'{group} transform="translate(30,-10) rotate(90 5 5) scale(2)"'))
    drawing, _ = read_svg_taxels(path)
    found = place_as_drawn(document, drawing)
    before, after = document.layout.placements[1], found.layout.placements[1]
    assert (after.scale / before.scale, after.angle - before.angle) == pytest.approx((2.0, -np.pi / 2), abs=1e-3)
    first, last = document.skin.first[1:3]
    row = drawing.numbers.tolist().index(int(first))
    np.testing.assert_allclose(found.map.taxel_points[first], drawing.points[row], atol=5e-6)
    kept = np.r_[0:first, last : len(document.skin)]
    np.testing.assert_array_equal(found.map.taxel_points[kept], document.map.taxel_points[kept])


def test_points_keep_their_place_on_the_body_on_the_map_of_another_skin(document):
    before = document.map
    after = move(rotate(document, [0, 1, 2], 0.7), [0], (0.3, -0.2)).map
    points = np.array([before.to_map(before.skin.taxel_point(k)) for k in (0, 5, len(before.skin) - 1)])
    found = points_on_other_map(points, before, after)
    for point, other in zip(points, found, strict=True):
        places = [map_.skin.position(map_.to_body(at)) for map_, at in ((before, point), (after, other))]
        np.testing.assert_allclose(*places, atol=1e-9)


def test_points_on_bare_links_or_too_far_from_the_skin_have_no_place_on_another_map(document):
    map_ = document.map
    points = np.array([map_.to_map(map_.skin.taxel_point(0))])
    assert points_on_other_map(points + 100.0, map_, map_) is None
    surface = map_.skin.patches[0].surface
    lifted = Mesh(surface.vertices + [0.0, 0.0, 1.0], surface.faces)
    for changed in ({"link": "other"}, {"surface": lifted}):
        other = replace(map_, skin=_skin_with(map_.skin, 0, **changed))
        assert points_on_other_map(points, map_, other) is None


def test_different_surface_link_or_taxel_is_a_different_skin(document):
    skin = document.skin
    patch = document.skin.patches[0]
    moved = Mesh(patch.surface.vertices + [1e-9, 0, 0], patch.surface.faces)
    weights = patch.taxels.weights.copy()
    weights[0] = np.roll(weights[0], 1)
    assert (weights != patch.taxels.weights).any()
    for changed in ({"surface": moved}, {"link": "other"}, {"taxels": replace(patch.taxels, weights=weights)}):
        assert not same_skin(skin, _skin_with(skin, 0, **changed))
    assert not same_skin(skin, Skin(skin.patches[:2]))


def test_everything_except_the_skin_is_copied(document, reflattened):
    other = document_from_bytes(document_to_bytes(rename_patch(rotate(reflattened, [0], 1.0), 1, "Sheet")))
    taken = adopt_document(document, other)
    assert taken.skin is document.skin
    assert taken.charts == other.charts
    assert taken.layout == other.layout
    assert taken.patches == other.patches
    np.testing.assert_array_equal(taken.map.taxel_points, other.map.taxel_points)
    assert adopt_document(document, document) is document


def test_document_of_another_skin_is_rejected(document):
    map_ = document.map
    other = replace(map_, skin=_skin_with(map_.skin, 1, link="other"))
    with pytest.raises(MapError, match="another skin"):
        adopt_document(document, MapDocument.of(other))


def test_saved_maps_documents_and_drawings_are_read(document, tmp_path):
    save_document(move(document, [0], (1.0, 0.0)), tmp_path / "document.npz")
    save_map(document.map, tmp_path / "map.npz")
    assert read_other_layout([tmp_path / "document.npz"], document).layout != document.layout
    assert read_other_layout([tmp_path / "map.npz"], document).layout == document.layout
    for ending in (".npz", ".csv"):
        path = tmp_path / f"drawn{ending}"
        write_taxels(document.skin, path, points=document.map.taxel_points)
        other = read_other_layout([path], document)
        assert isinstance(other, TaxelLayout)
        order = np.argsort(other.numbers)
        np.testing.assert_allclose(other.points[order], document.map.taxel_points, atol=1e-6)


def test_icub_layout_is_read_along_with_its_positions(tmp_path):
    document = MapDocument.of(build_map(skin_of(sheet(8, 6), taxels=36)))
    modules = tuple(LayoutModule(k, 0.1 * k, 0.02, 0.5 * k) for k in range(3))
    layout = IcubLayout("patch", modules)
    write_icub_layout(layout, tmp_path / "patch.ini")
    write_taxels(document.skin, tmp_path / "patch.txt")
    drawn = read_other_layout([tmp_path / "patch.txt", tmp_path / "patch.ini"], document)
    assert isinstance(drawn, TaxelLayout)
    np.testing.assert_array_equal(drawn.numbers, layout.numbers)
    np.testing.assert_allclose(drawn.points, layout.points, atol=1e-5)


def test_layout_of_another_skin_is_rejected(document, tmp_path):
    sheet = replace(document.map, skin=_skin_with(document.skin, 1, link="other"))
    save_map(sheet, tmp_path / "other.npz")
    (tmp_path / "broken.npz").write_bytes(b"PK nothing")
    (tmp_path / "layout.ini").write_text("")
    with pytest.raises(MapError, match=r"other.npz: the map is of another skin.*Open the robot"):
        read_other_layout([tmp_path / "other.npz"], document)
    with pytest.raises(MapError, match="damaged"):
        read_other_layout([tmp_path / "broken.npz"], document)
    with pytest.raises(
        MapError, match=r"layout\.ini: a layout has no positions on the body.*together with the positions"
    ):
        read_other_layout([tmp_path / "layout.ini"], document)
    with pytest.raises(MapError, match="not one layout"):
        read_other_layout([tmp_path / "other.npz", tmp_path / "broken.npz"], document)
    write_taxels(document.skin, tmp_path / "places.csv")
    with pytest.raises(MapError, match="no map points"):
        read_other_layout([tmp_path / "places.csv"], document)


def test_taxels_of_links_are_matched_on_their_own_link(document):
    """Two links' frames overlap, so that the nearest taxel of all may be the wrong one."""
    skin = _skin_with(_skin_with(document.skin, 0, link="a"), 1, link="a")
    skin = _skin_with(skin, 2, link="b", surface=skin.patches[1].surface, taxels=skin.patches[1].taxels)
    count = len(skin)
    points = np.arange(2.0 * count).reshape(count, 2) / count
    sets = taxel_sets(skin, points=points)
    assert [taxels.link for taxels in sets] == ["a", "b"]
    drawn = drawing_from_taxels(sets, skin)
    np.testing.assert_array_equal(drawn.numbers, np.arange(count))
    np.testing.assert_array_equal(drawn.points, points)


def _drawn(document, scale=0.3):
    """A drawing of the document's own map at another size; each patch turned and one mirrored."""
    turned = mirror(rotate(rotate(document, [0], 2.5), [1], -1.0), [2])
    return turned, TaxelLayout(scale * turned.map.taxel_points)


def test_patches_are_aligned_with_their_drawing_at_true_size(document):
    turned, drawing = _drawn(document)
    arranged = arrange_as_drawn(document, drawing)
    assert [p.scale for p in arranged.layout.placements] == [1.0, 1.0, 1.0]
    assert [p.mirrored for p in arranged.layout.placements] == [False, False, True]
    np.testing.assert_allclose(arranged.map.taxel_points, turned.map.taxel_points, atol=1e-9)
    assert arranged.charts == document.charts


def test_patch_missing_in_the_drawing_is_unchanged(document):
    _, drawing = _drawn(document)
    first, end = document.skin.first[1:3]
    part = TaxelLayout(drawing.points[first:end], np.arange(first, end))
    arranged = arrange_as_drawn(document, part)
    assert arranged.layout.placements[0] == document.layout.placements[0]
    assert arranged.layout.placements[1] != document.layout.placements[1]
    requested = pin_as_drawn(document, part)
    assert [job.number for job in requested.jobs] == [1]


def test_pins_bring_the_map_to_the_drawing_without_flips(document):
    """Drawn with one half longer than it is: no rigid motion can do that."""
    points = document.map.taxel_points.copy()
    points[:, 1] += 3.0 * np.maximum(points[:, 1] - points[:, 1].mean(), 0) ** 2
    drawing = TaxelLayout(points)
    before = procrustes(points, document.map.taxel_points, document.skin.first)
    pinned = apply_result(document, reflatten(pin_as_drawn(document, drawing)))
    after = procrustes(points, pinned.map.taxel_points, document.skin.first)
    assert after < 0.3 * before
    assert not any(flipped(chart.plane, chart.faces).any() for chart in pinned.charts)
    assert all(patch.pins for patch in pinned.patches)


def test_drawing_of_the_map_itself_does_not_change_it(document):
    drawing = TaxelLayout(document.map.taxel_points)
    pinned = apply_result(document, reflatten(pin_as_drawn(document, drawing)))
    np.testing.assert_allclose(pinned.map.taxel_points, document.map.taxel_points, atol=2e-3)


def test_proposed_pins_are_few_and_far_apart(document):
    _, drawing = _drawn(document)
    jobs = pin_as_drawn(document, drawing, most=5).jobs
    assert [len(job.edit.pins) for job in jobs] == [5, 5, 5]
    faces = {(pin.at.face, pin.at.weights) for pin in jobs[0].edit.pins}
    assert len(faces) == 5


def test_empty_drawing_is_rejected(document):
    nowhere = TaxelLayout(np.zeros((len(document.skin), 2)))
    for act in (arrange_as_drawn, pin_as_drawn):
        with pytest.raises(MapError, match="the drawing has no taxel of this skin"):
            act(document, nowhere)


def test_taxel_sets_without_positions_are_ignored_if_others_have_them(document):
    (taxels, *_) = taxel_sets(document.skin, points=document.map.taxel_points)
    bare = TaxelSet("bare", taxels.link, taxels.numbers, taxels.positions)
    assert len(drawing_from_taxels([bare, taxels], document.skin).points) == len(taxels)
