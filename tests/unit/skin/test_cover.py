from __future__ import annotations

import numpy as np
import pytest

from app.errors import MeshError, RobotError, SkinError
from app.skin.cover import JOINT_CLEARANCE, cover
from app.skin.cover_spec import CoverSpec
from tests.numerics.hard_meshes import HARD_MESHES, HOPELESS_MESHES, one_link
from tests.unit.skin.robots_by_hand import two_rods


def test_the_joint_is_kept_clear_and_the_total_is_as_asked() -> None:
    skin = cover(two_rods(buried=0.05), CoverSpec(("base", "upper"), taxels=101))
    assert len(skin) == 101
    assert [(patch.name, patch.link) for patch in skin.patches] == [("base", "base"), ("upper", "upper")]
    upper = skin.patches[1].surface.vertices
    assert upper[:, 2].min() > 0.05 + 0.5 * JOINT_CLEARANCE, "the base reaches 50 mm up the rod"


def test_taxels_are_shared_out_by_area() -> None:
    skin = cover(two_rods(), CoverSpec(("base", "upper"), taxels=200))
    density = [len(patch.taxels) / patch.surface.area for patch in skin.patches]
    assert density[0] == pytest.approx(density[1], rel=0.03)


def test_no_links_named_chooses_by_itself() -> None:
    assert {patch.link for patch in cover(two_rods(), CoverSpec(taxels=50)).patches} == {"upper"}


def test_progress_is_told_and_may_cancel() -> None:
    class Cancelled(Exception):
        pass

    told: list[tuple[str, float]] = []
    cover(two_rods(), CoverSpec(taxels=50), progress=lambda text, done: told.append((text, done)))
    assert told[0] == ("Covering upper", 0.0)
    assert [done for _, done in told] == sorted(done for _, done in told)

    def cancel(_text: str, _done: float) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        cover(two_rods(), CoverSpec(taxels=50), progress=cancel)


def test_an_unknown_link_and_one_without_geometry_are_named() -> None:
    with pytest.raises(RobotError, match="elbow"):
        cover(two_rods(), CoverSpec(("elbow",)))
    with pytest.raises(SkinError, match="found: frame"):
        cover(two_rods(), CoverSpec(("frame",)))


@pytest.mark.parametrize("name", HOPELESS_MESHES)
def test_a_link_without_area_is_a_named_error(name: str) -> None:
    with pytest.raises((SkinError, MeshError), match=r"part.*area|geometry.*part"):
        cover(one_link(HOPELESS_MESHES[name]), CoverSpec(("part",), taxels=20))


def test_a_link_buried_in_its_neighbour_stays_bare() -> None:
    with pytest.raises(SkinError, match="no surface is left"):
        cover(two_rods(buried=0.15, length=0.1), CoverSpec(("upper",), taxels=20))


def test_repairs_are_told() -> None:
    skin = cover(one_link(HARD_MESHES["duplicates"]), CoverSpec(taxels=20))
    assert {finding.kind for finding in skin.findings} == {"duplicate-vertex", "duplicate-face"}
    assert np.isfinite(skin.areas).all()
