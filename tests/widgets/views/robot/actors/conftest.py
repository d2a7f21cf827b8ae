"""A plain plotter, and the small arm on it."""

from __future__ import annotations

import pytest
import pyvista as pv

from tactile_widgets.common.colours import DARK, PressureScale
from tactile_widgets.views.robot.actors.robot_actors import RobotActors
from tests.widgets.support.robot_view_driver import PICTURE


@pytest.fixture
def plotter():
    plotter = pv.Plotter(off_screen=True, window_size=PICTURE, lighting="none")
    yield plotter
    plotter.close()


@pytest.fixture
def scene(plotter, prepared):
    scene = RobotActors(plotter, DARK, PressureScale())
    scene.show_prepared(prepared)
    return scene
