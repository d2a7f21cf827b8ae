"""Waiting times in the complete window: press, theme, controller, seeking in a long recording, and closing."""

from __future__ import annotations

from dataclasses import replace
from itertools import count, cycle

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.recording.recorder import record
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_maps.session.prepared_cache import link_levels_cached, prepare_cached
from tactile_maps.session.session import Session
from tactile_maps.tactile.poke import PokePressed
from tactile_widgets.common.mode import Mode
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.session.backends import BACKGROUND, INLINE
from tests.widgets.support.window_driver import close_window, open_window

MINUTES = 10


@pytest.fixture(scope="module")
def prepared():
    return prepare(load_scene("arm"))


@pytest.fixture
def window(qapp, prepared, tmp_path):
    made = open_window(tmp_path, INLINE)
    made.live.show_prepared(prepared)
    for _ in range(20):
        _advance(made, 0.05)
    yield made
    close_window(made)


def _advance(window, seconds):
    """Advance the simulation and update both views; the map is painted at once, as in the window."""
    window.live.runner.run_for(seconds)
    window.live.pump()
    QApplication.processEvents()
    window.robot_view.display.draw_now()


def _paint(window):
    QApplication.processEvents()
    window.robot_view.display.draw_now()
    window.map_view.viewport().repaint()


@pytest.mark.parametrize("taxels", [1_000, 10_000])
def test_frame_of_both_views_under_pressing_fingers(benchmark, window, taxels):
    """Measure a frame of both views in a scene with pressing fingers, including the simulation."""
    scene = load_scene("many_pokes")
    window.live.show_prepared(prepare(replace(scene, cover=replace(scene.cover, taxels=taxels))))
    for _ in range(20):
        _advance(window, 0.05)
    assert window.live.shown.regions
    benchmark.pedantic(_advance, args=(window, 1 / 30), rounds=60, warmup_rounds=5)
    if benchmark.stats is not None:
        benchmark.extra_info["frames a second"] = round(1 / benchmark.stats.stats.median)


@pytest.mark.parametrize("coarse", [False, True])
def test_frame_of_a_robot_of_many_triangles(benchmark, window, pytestconfig, coarse):
    """Measure both views of the complete iCub, with full and with reduced meshes."""
    scene = load_scene("icub_whole" if pytestconfig.getoption("benchmark_enable") else "arm")
    shown = prepare_cached(scene)
    window.live.show_prepared(shown)
    if coarse:
        window.robot_view.display.set_link_levels(link_levels_cached(shown.robot))
    for finger, patch in enumerate(range(0, len(shown.skin.patches), 3)):
        middle = int(shown.skin.first[patch : patch + 2].mean())
        window.live.runner.submit(PokePressed(finger, shown.skin.taxel_point(middle)))
    for _ in range(20):
        _advance(window, 0.05)
    benchmark.pedantic(_advance, args=(window, 1 / 30), rounds=60, warmup_rounds=5)
    drawn = [actor.mapper.GetInput().GetNumberOfCells() for _, actor in window.robot_view.display.actors.links.placed]
    benchmark.extra_info["triangles of links"] = sum(drawn)


def test_press_on_the_map_until_both_views_are_painted(benchmark, window, prepared):
    viewport = window.map_view.viewport()
    tick = prepared.scene.tick
    pixel = window.map_view.pixel_of(prepared.skin.taxel_point(len(prepared.skin) // 2)).toPoint()

    def press():
        QTest.mousePress(viewport, Qt.MouseButton.LeftButton, pos=pixel)
        _advance(window, tick)

    def release():
        QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=pixel)
        _advance(window, 0.1)

    benchmark.pedantic(press, setup=release, rounds=30, warmup_rounds=3)


def test_theme_change(benchmark, window):
    names = cycle(("light", "dark"))
    benchmark.extra_info["widgets"] = len(QApplication.allWidgets())

    def switch():
        window.set_theme(next(names))
        _paint(window)

    benchmark.pedantic(switch, rounds=20, warmup_rounds=2)


def test_controller_change(benchmark, window, prepared):
    names = cycle(("hybrid", "priority", "impedance", "projection"))

    def switch():
        window.findChild(ControllerPanel).choose_controller(next(names))
        _advance(window, prepared.scene.tick)

    benchmark.pedantic(switch, rounds=20, warmup_rounds=4)


def test_scrubbing_in_a_long_recording(benchmark, window, prepared, tmp_path, pytestconfig):
    seconds = 60.0 * MINUTES if pytestconfig.getoption("benchmark_enable") else 2.0
    path = tmp_path / "long.mcap"
    session = Session(prepared)
    with record(session, path):
        while session.frame is None or session.frame.time < seconds:
            session.tick()
    benchmark.extra_info["minutes, MB"] = f"{seconds / 60:.0f}, {path.stat().st_size / 1e6:.0f}"
    window.live.open_recording(path)
    while window.live.mode is not Mode.REPLAYING:
        QApplication.processEvents()
    places = iter(np.random.default_rng(0).uniform(0, seconds - 0.1, 200))

    def scrub():
        window.live.replay.seek(next(places))
        _paint(window)

    benchmark.pedantic(scrub, rounds=60, warmup_rounds=3)


def test_closing_the_window_during_a_session(benchmark, qapp, prepared, tmp_path):
    """Measure closing, including the session's thread and the processes."""
    numbers = count()

    def opened():
        folder = tmp_path / str(next(numbers))
        folder.mkdir()
        made = open_window(folder, BACKGROUND)
        made.live.show_prepared(prepared)
        for _ in range(30):
            QTest.qWait(20)
        return (made,), {}

    benchmark.pedantic(close_window, setup=opened, rounds=5)
