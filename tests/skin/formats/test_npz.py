from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import SkinError
from tactile_maps.core.files import pack_arrays
from tactile_maps.skin.formats.npz import FORMAT, VERSION, read_taxel_npz
from tests.support.findings import kinds


def saved(tmp_path, **arrays):
    np.savez(tmp_path / "patch.npz", **arrays)
    return tmp_path / "patch.npz"


def test_plain_array_names_of_another_program_are_read(tmp_path):
    (taxels,) = read_taxel_npz(
        saved(tmp_path, positions=np.eye(3, dtype=np.float32), normals=2 * np.eye(3), other=np.ones(9))
    )
    assert (taxels.name, taxels.link, taxels.numbers.tolist()) == ("patch", None, [0, 1, 2])
    assert taxels.normals.tolist() == np.eye(3).tolist()
    assert kinds(taxels.findings) == {"normals-not-unit": 3}
    (twice,) = read_taxel_npz(saved(tmp_path, positions=np.eye(3), numbers=np.array([1, 1, 2], dtype=np.uint8)))
    assert kinds(twice.findings) == {"duplicate-number": 1}


@pytest.mark.parametrize(
    ("arrays", "problem"),
    [
        ({"other": np.eye(3)}, "no positions.*other.*Name the array"),
        ({"positions": np.ones((4, 2))}, "positions.*wrong shape or type"),
        ({"positions": np.float64(1)}, "positions.*wrong shape or type"),
        ({"positions": np.eye(3) + 0j}, "only arrays of numbers"),
        ({"positions": np.eye(3), "numbers": np.ones(3)}, "numbers.*wrong shape or type"),
        ({"positions": np.eye(3), "numbers": np.full(3, 2**64 - 1, dtype=np.uint64)}, "implausibly large"),
        ({"positions": np.eye(3), "numbers": np.arange(2)}, "numbers.*rows or columns"),
        ({"positions": np.eye(3), "faces": np.array([[0, 1, -3]])}, "does not exist"),
        ({"positions": np.eye(3) * np.nan}, "not a finite"),
        ({"positions": np.eye(3), "normals": np.zeros((0, 3))}, None),
        ({"positions": np.array([{}], dtype=object)}, "only arrays of numbers"),
    ],
)
def test_invalid_arrays_are_rejected_by_name(tmp_path, arrays, problem):
    if problem is None:
        assert read_taxel_npz(saved(tmp_path, **arrays))[0].normals is None
    else:
        with pytest.raises(SkinError, match=rf"patch\.npz.*{problem}"):
            read_taxel_npz(saved(tmp_path, **arrays))


@pytest.mark.parametrize(
    ("header", "problem"),
    [
        ({"format": "tactile-maps-skin", "version": 1}, "not a file of taxels.*skins and maps as such"),
        ({"format": FORMAT, "version": 99}, "not a file of taxels"),
        ({"format": FORMAT, "version": VERSION}, "header of the file is broken"),
        ({"format": FORMAT, "version": VERSION, "sets": []}, "header of the file is broken"),
        ({"format": FORMAT, "version": VERSION, "sets": [["a"]]}, "header of the file is broken"),
        ({"format": FORMAT, "version": VERSION, "sets": [["a", 5]]}, "header of the file is broken"),
        ({"format": FORMAT, "version": VERSION, "sets": [["a", None]]}, "no positions"),
    ],
)
def test_other_files_of_this_program_are_rejected(tmp_path, header, problem):
    (tmp_path / "patch.npz").write_bytes(pack_arrays(header, {"positions": np.eye(3)}))
    with pytest.raises(SkinError, match=problem):
        read_taxel_npz(tmp_path / "patch.npz")
