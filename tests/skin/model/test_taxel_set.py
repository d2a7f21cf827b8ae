from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import Finding, SkinError
from tactile_maps.skin.model.taxel_set import TaxelSet, distinct_numbers, unit_normals
from tests.support.example_taxels import dome
from tests.support.findings import kinds


def test_arrays_are_copied_and_read_only():
    positions = np.eye(3)
    taxels = TaxelSet("patch", None, np.arange(3), positions)
    positions[0] = 9
    assert taxels.positions[0].tolist() == [1, 0, 0]
    assert not taxels.positions.flags.writeable
    assert len(taxels) == 3
    assert not taxels.mapped.any()


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"positions": np.zeros((0, 3))}, "1 to 100,000"),
        ({"positions": np.full((12, 3), np.nan)}, "row 0: a position is not a finite"),
        ({"positions": np.full((12, 3), 30.8)}, "in metres.*30.8"),
        ({"positions": np.zeros((12, 2))}, "positions.*rows or columns"),
        ({"numbers": np.arange(11)}, "numbers.*rows or columns"),
        ({"numbers": -np.arange(12)}, "numbers, row 1.*negative.*-1"),
        ({"numbers": np.full(12, 5)}, "numbers, row 1.*same number.*5"),
        ({"normals": np.full((12, 3), 0.5)}, "normals, row 0.*length one"),
        ({"normals": np.full((12, 3), np.nan)}, "normals, row 0.*length one"),
        ({"points": np.full((12, 2), 1e3)}, "map point is not within"),
        ({"points": np.full((12, 2), np.inf)}, "map point is not within"),
        ({"points": np.tile([np.nan, 0.0], (12, 1))}, "map point is not within"),
        ({"modules": -np.ones(12)}, "modules, row 0.*negative"),
        ({"faces": np.array([[0, 1, 2], [3, 4, 12]])}, "faces, row 1.*does not exist"),
        ({"faces": np.zeros((2, 4))}, "faces.*rows or columns"),
    ],
)
def test_invalid_taxels_are_rejected_with_their_number(changes, problem):
    with pytest.raises(SkinError, match=problem):
        dome(**changes)


def test_selection_keeps_all_properties_of_a_taxel():
    points = dome().points.copy()
    points[4:] = np.nan
    taxels = dome(points=points, faces=np.array([[0, 1, 2], [1, 2, 5], [3, 2, 1]]))
    shown = taxels.select(taxels.mapped)
    assert len(shown) == 4
    assert shown.faces.tolist() == [[0, 1, 2], [3, 2, 1]]
    np.testing.assert_array_equal(shown.numbers, taxels.numbers[:4])
    np.testing.assert_array_equal(shown.normals, taxels.normals[:4])
    bare = TaxelSet("patch", None, np.arange(3), np.eye(3)).select(np.array([False, True, True]))
    assert bare.numbers.tolist() == [1, 2]
    assert bare.normals is None


def test_findings_are_added_not_replaced():
    taxels = dome().with_findings(Finding("a", "x", "y")).with_findings(Finding("b", "x", "y", 2))
    assert kinds(taxels.findings) == {"a": 1, "b": 2}


def test_repeated_numbers_are_replaced_by_the_order():
    findings = []
    assert distinct_numbers([5, 9, 5, 5], "file", findings).tolist() == [0, 1, 2, 3]
    assert kinds(findings) == {"duplicate-number": 2}
    assert distinct_numbers([5, 9], "file", findings).tolist() == [5, 9]
    assert len(findings) == 1


def test_normals_are_normalized_or_dropped_if_zero():
    findings = []
    normals = unit_normals(np.array([[0, 0, 1e-200], [1e200, 1e200, 0], [1.0, 0, 0]]), "file", findings)
    np.testing.assert_allclose(normals, [[0, 0, 1], [0.5**0.5, 0.5**0.5, 0], [1, 0, 0]], atol=1e-15)
    assert kinds(findings) == {"normals-not-unit": 2}
    assert unit_normals(np.array([[0.0, 0, 0], [1, 0, 0]]), "file", findings) is None
    assert unit_normals(np.array([[np.nan, 0, 0], [1, 0, 0]]), "file", findings) is None
