from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.core.files import pack_arrays, unpack_arrays
from tactile_maps.skin.model import skin_file
from tactile_maps.skin.model.skin import Patch, Skin, TaxelIdentity
from tactile_maps.skin.model.skin_file import load_skin, save_skin, skin_from_bytes, skin_to_bytes
from tactile_maps.skin.taxel_placement.sampling import place_evenly
from tests.hard_cases.meshes import HARD_MESHES

Header = dict[str, object]
Arrays = dict[str, np.ndarray]


def skin():
    ball = HARD_MESHES["sphere"]
    tube = HARD_MESHES["open tube"]
    patches = (Patch("ball", "a", ball, place_evenly(ball, 5)), Patch("Röhre", "b", tube, place_evenly(tube, 7)))
    return Skin(patches, (Finding("duplicate-face", "a", "dropped", 3),))


def changed(change):
    header, arrays = unpack_arrays(skin_to_bytes(skin()), error=SkinError)
    arrays = {name: values.copy() for name, values in arrays.items()}
    change(header, arrays)
    return pack_arrays(header, arrays)


def test_skin_is_restored_bit_for_bit(tmp_path):
    save_skin(skin(), tmp_path / "skin.npz")
    loaded = load_skin(tmp_path / "skin.npz")
    assert loaded.findings == skin().findings
    assert [(p.name, p.link) for p in loaded.patches] == [("ball", "a"), ("Röhre", "b")]
    assert skin_to_bytes(loaded) == skin_to_bytes(skin())
    assert [path.name for path in tmp_path.iterdir()] == ["skin.npz"], "nothing half-written is left"


def test_aliases_and_stream_are_kept():
    ball, tube = skin().patches
    identity = TaxelIdentity(ids=np.arange(5), aliases=[[7, 4], [8, 0]], stream=12)
    named = Skin((replace(ball, taxels=replace(ball.taxels, identity=identity)), tube))
    back = skin_from_bytes(skin_to_bytes(named))
    found = back.patches[0].taxels.identity
    assert (found.aliases.tolist(), found.stream) == ([[7, 4], [8, 0]], 12)
    assert back.patches[1].taxels.identity.aliases is None
    assert [back.taxels_with_id(number).tolist() for number in (7, 8)] == [[4], [0]]


def test_axes_and_tangents_need_version_5_and_are_kept():
    ball, tube = skin().patches
    tangents = np.cross(tube.taxels.normals, [0.0, 0.0, 1.0])
    tangents[2] = np.nan
    axes = [3, 3, 1, 3, 3, 1, 3]
    three = Skin((ball, replace(tube, taxels=replace(tube.taxels, axes=axes, tangents=tangents))))
    data = skin_to_bytes(three)
    back = skin_from_bytes(data)
    assert back.patches[0].taxels.axes is None
    assert back.patches[1].taxels.axes.tolist() == axes
    np.testing.assert_array_equal(back.patches[1].taxels.tangents, tangents)
    assert skin_to_bytes(back) == data
    versions = [unpack_arrays(skin_to_bytes(one), error=SkinError)[0]["version"] for one in (three, skin())]
    assert versions == [5, 2], "the earliest version that has all of the skin"


@pytest.mark.parametrize(
    ("arrays", "problem"),
    [
        ({"0_axes": np.full(5, 2)}, "patch ball, axes, row 0: invalid number of axes.*2"),
        ({"0_axes": np.full(4, 3)}, "patch ball, axes: the number of rows"),
        ({"0_axes": np.full(5, 3.0)}, "patch ball, axes: an index is not a whole number"),
        ({"1_tangents": np.ones((7, 2))}, "patch Röhre, tangents: an array has the wrong shape"),
        ({"1_tangents": np.ones((7, 3))}, "patch Röhre, tangents, row 0: a tangent is not of length one"),
    ],
)
def test_invalid_axes_in_a_file_are_rejected_by_name(arrays, problem):
    with pytest.raises(SkinError, match=f"hand.npz.*{problem}"):
        skin_from_bytes(changed(lambda _h, a: a.update(arrays)), file="hand.npz")


def test_bare_area_is_kept(tmp_path):
    save_skin(replace(skin(), bare_area=0.25), tmp_path / "skin.npz")
    assert load_skin(tmp_path / "skin.npz").bare_area == 0.25
    assert load_skin(tmp_path / "skin.npz").coverage < 1 == skin().coverage


def test_numpy_opens_it_without_pickles(tmp_path):
    save_skin(skin(), tmp_path / "skin.npz")
    with np.load(tmp_path / "skin.npz", allow_pickle=False) as data:
        assert data["1_positions"].shape == (7, 3)


def test_skin_without_patches_is_restored():
    assert len(skin_from_bytes(skin_to_bytes(Skin(())))) == 0


def test_missing_file_and_an_unwritable_place_are_named(tmp_path):
    with pytest.raises(SkinError, match="nowhere.npz.*cannot be read"):
        load_skin(tmp_path / "nowhere.npz")
    with pytest.raises(SkinError, match="cannot be written"):
        save_skin(skin(), tmp_path / "no folder" / "skin.npz")


def test_too_large_file_is_not_read(tmp_path, monkeypatch):
    save_skin(skin(), tmp_path / "skin.npz")
    monkeypatch.setattr(skin_file, "MAX_UNPACKED_BYTES", 10)
    with pytest.raises(SkinError, match="too large"):
        load_skin(tmp_path / "skin.npz")


def test_too_many_taxels_are_rejected(monkeypatch):
    monkeypatch.setattr(skin_file, "MAX_TAXELS", 11)
    with pytest.raises(SkinError, match="too many taxels"):
        skin_from_bytes(skin_to_bytes(skin()))


@pytest.mark.long
@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda h, _a: h.update(format="other"), "not a skin file"),
        (lambda h, _a: h.update(version=99), "unknown version"),
        (lambda h, _a: h.update(patches=3), "header .*is broken"),
        (lambda h, _a: h.update(patches=[{"name": 1, "link": "a"}]), "header .*is broken"),
        (lambda h, _a: h.update(findings=[["a", "b"]]), "header .*is broken"),
        (lambda h, _a: h.update(bare_area=-1.0), "header .*is broken"),
        (lambda h, _a: h.update(bare_area="much"), "header .*is broken"),
        (lambda h, _a: h["patches"][1].update(name="ball"), "same name"),
        (lambda h, _a: h["patches"][0].update(taxels=["a", 3]), "header .*is broken"),
        (lambda h, _a: h["patches"][0].update(taxels=["a"]), "patch ball, taxels.*5 rows expected"),
        (lambda _h, a: a.pop("0_areas"), "patch ball, areas.*missing"),
        (lambda _h, a: a.update({"0_areas": a["0_areas"][:-1]}), "patch ball, areas.*5 rows expected"),
        (lambda _h, a: a.update({"0_areas": np.float64(3)}), "wrong shape"),
        (lambda _h, a: a.update({"0_positions": a["0_positions"][:, :2]}), "wrong shape"),
        (lambda _h, a: a["0_positions"].__setitem__(0, np.nan), "positions.*not finite"),
        (lambda _h, a: a["0_faces"].__setitem__(0, 10**9), "faces.*no such face.*1000000000"),
        (lambda _h, a: a["0_faces"].__setitem__(0, -1), "no such face"),
        (lambda _h, a: a["0_neighbours"].__setitem__((0, 0), 5), "no such taxel"),
        (lambda _h, a: a["0_quadrature_taxel"].__setitem__(0, 99), "no such taxel"),
        (lambda _h, a: a.update({"0_faces": a["0_faces"].astype(float)}), "not a whole number"),
        (lambda _h, a: a["0_surface_faces"].__setitem__((0, 0), 10**6), "surface of the patch is broken"),
        (lambda _h, a: a["0_areas"].__setitem__(0, 0.0), "not above zero"),
        (lambda _h, a: a["0_areas"].__setitem__(0, 1.0), "not the sums"),
        (lambda _h, a: a["0_weights"].__setitem__(0, [1, 1, -1]), "barycentric"),
        (lambda _h, a: a.update({"0_ids": np.arange(4)}), "patch ball, ids.*5 rows expected.*4"),
        (lambda _h, a: a.update({"0_modules": np.ones(5)}), "patch ball, modules.*not a whole number"),
        (lambda _h, a: a.update({"1_channels": np.arange(7) - 1}), "patch Röhre, channels, row 0.*negative.*-1"),
        (lambda _h, a: a.update({"0_ids": np.arange(5), "0_aliases": np.array([[9, 5]])}), "invalid alias.*9, 5"),
        (lambda h, _a: h["patches"][0].update(stream="12"), "header of the skin file is broken"),
        (lambda _h, a: a.update({"1_ids": np.full(7, 2**31)}), "patch Röhre, ids, row 0.*above.*2147483648"),
    ],
)
def test_invalid_skin_is_rejected_by_name(change, problem):
    with pytest.raises(SkinError, match=f"hand.npz.*{problem}"):
        skin_from_bytes(changed(change), file="hand.npz")
