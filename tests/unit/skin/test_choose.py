from __future__ import annotations

import numpy as np
import pytest

from app.errors import SkinError
from app.geometry.mesh import Mesh
from app.robots.robot import Robot
from app.skin.choose import choose_links, hull_area
from tests.numerics.hard_meshes import HARD_MESHES, one_link
from tests.unit.skin.robots_by_hand import two_rods


def test_only_links_that_move_are_chosen() -> None:
    assert choose_links(two_rods()) == ("upper",)


def test_a_robot_without_joints_wears_it_on_any_link() -> None:
    assert choose_links(one_link(HARD_MESHES["cube"])) == ("part",)


def test_a_flat_link_can_be_chosen_too() -> None:
    assert choose_links(one_link(HARD_MESHES["flat plate"])) == ("part",)


def test_a_robot_without_geometry_is_refused() -> None:
    bare = Robot(
        "bare", "bare.xml", '<mujoco><worldbody><body name="b"/></worldbody></mujoco>', {}, (), (), np.zeros(0)
    )
    with pytest.raises(SkinError, match="geometry"):
        choose_links(bare)


def test_hull_area_of_a_cube_is_its_area_and_of_a_plate_one_side() -> None:
    assert hull_area(HARD_MESHES["cube"]) == pytest.approx(HARD_MESHES["cube"].area)
    assert hull_area(HARD_MESHES["flat plate"]) == pytest.approx(0.06)
    assert hull_area(Mesh(np.eye(3), [[0, 1, 2]])) == pytest.approx(np.sqrt(3) / 2)
