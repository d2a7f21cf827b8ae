"""The robot as a value."""

from __future__ import annotations

from pathlib import Path

import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.load import load_robot_file


def test_links_are_found_by_name_or_refused_with_the_valid_ones(tiny: Path) -> None:
    robot = load_robot_file(tiny)
    assert robot.link("rod") is robot.links[robot.link_index["rod"]]
    with pytest.raises(RobotError, match=r"tail.*Choose one of: base, rod"):
        robot.link("tail")
    with pytest.raises(ValueError, match="read-only"):
        robot.home[0] = 1.0
