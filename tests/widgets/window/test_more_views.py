"""Views that a person adds: the second camera, the contact enlarged, and links framed from the menu."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QApplication, QMenu

from tactile_maps.robots.kinematics import Configuration
from tests.widgets.support.mouse import left_click, left_double_click, left_drag
from tests.widgets.support.window_driver import run, visible_skin

pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    yield window_again
    window_again.more_views.close()
    window_again.robot_view.display.frame_all()


def eye(view):
    return view.display.actors.viewpoint.eye.copy()


@pytest.mark.long
def test_second_view_has_its_own_camera_and_follows_the_robot(window, qtbot):
    assert window.more_views.second is None
    window.action("second_view").trigger()
    QApplication.processEvents()
    view = window.more_views.second
    assert view.isVisible()
    first = eye(window.robot_view)
    assert np.linalg.norm(eye(view) - first) > 0.2, "it looks from another side"
    before = eye(view)
    canvas = view.display.canvas.widget
    left_drag(canvas, QPoint(60, 60), QPoint(100, 70))
    assert np.linalg.norm(eye(view) - before) > 0.05
    assert np.array_equal(eye(window.robot_view), first)
    assert not any(poke.id == 1 for poke in window.live.shown.pokes)
    run(window, 0.2)
    qtbot.waitUntil(lambda: view.display._frame is window.live.shown)
    window.more_views._dock.close()
    assert window.more_views.second is None
    assert not window.action("second_view").isChecked()


def test_second_view_shows_another_scene_in_a_later_event(window, prepared):
    window.action("second_view").trigger()
    display = window.more_views.second.display
    other = replace(prepared)
    window.live.show_prepared(other)
    assert display.prepared is prepared, "the robot view is built first"
    run(window, 0.1)
    assert display.prepared is other
    assert display._frame is window.live.shown
    window.live.show_prepared(prepared)
    window.more_views.close()
    QApplication.processEvents()


def test_inset_shows_the_strongest_contact_and_frames_it_by_double_click(window, qtbot):
    window.action("contact_inset").trigger()
    at, _ = visible_skin(window)
    window.presenters.touch.hold(at)
    run(window, 1.0)
    inset = window.more_views.inset
    qtbot.waitUntil(lambda: " N" in inset.words.text().replace("\u202f", " "))
    strongest = max(window.live.shown.regions, key=lambda region: region.force)
    configuration = Configuration(window.live.prepared.robot)
    configuration.update(window.live.shown.posture)
    place = configuration.pose(strongest.link).points(strongest.link_position)
    qtbot.waitUntil(lambda: bool(np.linalg.norm(inset.view.display.actors.viewpoint.focus - place) < 0.03))
    pokes = len(window.live.shown.pokes)
    before = eye(window.robot_view)
    left_click(inset.view.display.canvas.widget, QPoint(40, 40))
    run(window, 0.05)
    assert len(window.live.shown.pokes) == pokes, "what is under it is not pressed"
    left_double_click(inset.view.display.canvas.widget, QPoint(40, 40))
    assert np.linalg.norm(eye(window.robot_view) - before) > 0.05
    assert np.linalg.norm(window.robot_view.display.actors.viewpoint.focus - place) < 0.03
    window.action("contact_inset").trigger()
    assert window.more_views.inset is None


def test_second_view_floats_in_a_narrow_window(window):
    window.resize(900, 600)
    QApplication.processEvents()
    window.action("second_view").trigger()
    assert window.more_views._dock.isFloating()
    assert window.width() == 900
    window.action("second_view").trigger()
    window.resize(1400, 900)
    QApplication.processEvents()


def test_menu_frames_each_link(window):
    menu = QMenu(window)
    window.more_views.list_bodies(menu)
    names = [link.name for link in window.live.prepared.robot.links if link.mesh is not None]
    assert [entry.objectName() for entry in menu.actions()] == [f"frame-{name}" for name in names]
    far = window.robot_view.display.actors.viewpoint.distance
    menu.findChild(object, "frame-hand").trigger()
    view = window.robot_view.display.actors.viewpoint
    hand = window.robot_view.display.actors.body_poses[window.live.prepared.robot.link_index["hand"]][:3, 3]
    assert view.distance < far
    assert np.linalg.norm(np.cross(hand - view.eye, view.axes[2])) < 0.15
    menu.deleteLater()


def test_view_that_was_removed_is_not_shown_by_a_layout(window):
    docks = window.panel_docks
    without = docks.layout
    window.more_views.show_second(shown=True)
    run(window, 0.02)
    layout = docks.layout
    window.more_views.show_second(shown=False)  # its dock is deleted when the event loop continues
    docks.arrange(layout)
    QApplication.processEvents()
    assert window.more_views.second.isVisible()
    docks.arrange(replace(layout, views=()))
    QApplication.processEvents()
    window.resize(window.width() + 40, window.height())
    QApplication.processEvents()
    docks.arrange(without)
    assert window.more_views.second is None
