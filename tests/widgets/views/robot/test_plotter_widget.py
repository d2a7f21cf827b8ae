"""The canvases and when they draw: sharpness against time, many requests in one picture, a canvas chosen by hand."""

from __future__ import annotations

import os

import pytest
from PySide6.QtWidgets import QWidget

from tactile_maps.core.errors import DisplayError
from tactile_widgets.views.robot.plotter_widget import (
    HALF_RESOLUTION_FROM_MS,
    HALF_RESOLUTION_IN_A_ROW_FROM_MS,
    REDRAW_UP_TO_MS,
    REST_MS,
    ImageCanvas,
    RenderScheduler,
    make_canvas,
)


def test_mesa_has_no_shader_cache():
    """It would end the process on a full disk."""
    assert os.environ["MESA_SHADER_CACHE_DISABLE"] == "true"


class SlowCanvas(QWidget):
    """A canvas that takes a given time to draw, on its own clock."""

    def __init__(self, milliseconds):
        super().__init__()
        self.plotter = None
        self.widget = self
        self.milliseconds = milliseconds
        self.time = 0.0
        self.qualities = []

    def clock(self):
        return self.time

    def draw(self, *, quality=1.0):
        self.qualities.append(quality)
        self.time += 1e-3 * self.milliseconds * quality**2

    def close_plotter(self):
        """Do nothing; the canvas holds no resources."""


@pytest.fixture
def draw(qtbot):
    def make(milliseconds):
        canvas = SlowCanvas(milliseconds)
        qtbot.addWidget(canvas)
        return canvas, RenderScheduler(canvas, canvas, clock=canvas.clock)

    return make


def test_many_requests_become_one_picture_and_a_sharp_one(draw, qtbot):
    canvas, drawing = draw(5.0)
    for _ in range(20):
        drawing.request()
    assert canvas.qualities == []
    qtbot.waitUntil(lambda: len(canvas.qualities) == 2)
    assert canvas.qualities == [1.0, 2.0]


def test_slow_picture_has_low_resolution_while_the_view_moves(draw, qtbot):
    canvas, drawing = draw(HALF_RESOLUTION_FROM_MS + 10)
    drawing.now()
    drawing.request(moving=True)
    qtbot.waitUntil(lambda: len(canvas.qualities) == 3)
    assert canvas.qualities == [1.0, 0.5, 2.0]


def test_very_slow_picture_is_not_drawn_again(draw, qtbot):
    canvas, drawing = draw(REDRAW_UP_TO_MS + 20)
    drawing.now()
    drawing.request()
    qtbot.waitUntil(lambda: len(canvas.qualities) == 2)
    with qtbot.assertNotEmitted(drawing.drawn, wait=REST_MS + 100):
        assert canvas.qualities == [1.0, 1.0]


def test_consecutive_slow_pictures_have_low_resolution_until_changes_stop(draw, qtbot):
    canvas, drawing = draw(HALF_RESOLUTION_IN_A_ROW_FROM_MS + 10)
    drawing.drawn.connect(lambda _ms: len(canvas.qualities) < 6 and drawing.request())
    drawing.now()
    qtbot.waitUntil(lambda: len(canvas.qualities) == 7)
    assert canvas.qualities == [1.0, 1.0, 1.0, 0.5, 0.5, 0.5, 2.0]


def test_pause_after_a_picture_equals_its_duration_minus_the_time_of_the_map(draw, qtbot):
    canvas, drawing = draw(100.0)
    pauses = []

    def request(_ms):
        pauses.append([round(drawing.rest_ms(ahead)) for ahead in (0.0, 10.0, 1000.0)])
        if len(pauses) < 5:
            drawing.request()

    drawing.drawn.connect(request)
    drawing.now()
    qtbot.waitUntil(lambda: len(pauses) == 5)
    assert canvas.qualities == [1.0, 1.0, 1.0, 0.5, 0.5]
    assert pauses == [*3 * [[100, 90, 50]], *2 * [[25, 15, 12]]]


@pytest.fixture
def canvas(qtbot):
    canvas = ImageCanvas()
    qtbot.addWidget(canvas)
    canvas.resize(120, 80)
    canvas.show()
    yield canvas
    canvas.close_plotter()


@pytest.mark.parametrize("quality", [0.5, 1.0, 2.0])
def test_picture_fills_the_widget_at_any_quality(canvas, quality):
    canvas.plotter.set_background("#102030")
    canvas.draw(quality=quality)
    image = canvas.grab().toImage()
    ratio = image.devicePixelRatio()
    for x, y in ((0, 0), (119, 79), (60, 40)):
        colour = image.pixelColor(round(x * ratio), round(y * ratio))
        assert (colour.red(), colour.green(), colour.blue()) == (0x10, 0x20, 0x30)


def test_picture_is_upright(canvas):
    canvas.plotter.set_background("black", top="white")
    canvas.draw()
    image = canvas.grab().toImage()
    assert image.pixelColor(60, 2).lightness() > 200 > 60 > image.pixelColor(60, 77).lightness()


def test_closed_canvas_keeps_its_last_picture(canvas):
    canvas.plotter.set_background("white")
    canvas.draw()
    before = canvas.grab().toImage()
    canvas.close_plotter()
    canvas.draw()
    canvas.close_plotter()
    assert canvas.grab().toImage() == before


def test_image_canvas_is_used_without_a_display_and_on_request(qtbot, monkeypatch):
    for choice in ("", "image"):
        monkeypatch.setenv("TACTILE_MAPS_CANVAS", choice)
        canvas = make_canvas()
        qtbot.addWidget(canvas.widget)
        assert isinstance(canvas, ImageCanvas)
        canvas.close_plotter()


def test_unknown_canvas_is_rejected(monkeypatch):
    monkeypatch.setenv("TACTILE_MAPS_CANVAS", "crayons")
    with pytest.raises(DisplayError, match="crayons"):
        make_canvas()
