"""Figures for papers: requested size, vector graphics where possible, and an unchanged window."""

from __future__ import annotations

import re
import sys
import zlib
from base64 import b64decode
from io import BytesIO

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QFont, QFontMetricsF, QTransform
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import DisplayError
from tactile_widgets.__main__ import main
from tactile_widgets.common.settings import BaseLayer
from tactile_widgets.dialogs.figures.figure_file import FigureColours, FigurePart, FigureSpec, write_figure
from tactile_widgets.dialogs.figures.view_figure import ShownInViews, write_view_figure
from tactile_widgets.window.window_picture import check_picture_kind
from tests.widgets.support.mouse import left_click, left_release
from tests.widgets.support.samples import middle_taxel, touched
from tests.widgets.support.window_driver import press_map, run

SMALL = FigureSpec(80.0, 60.0, 96, FigureColours.PAPER)
WIDE = FigureSpec(160.0, 60.0, 96, FigureColours.PAPER)
pytestmark = pytest.mark.qt_log_ignore("This plugin does not support")


@pytest.fixture
def window(window_again):
    """The shared window; a figure leaves nothing in it."""
    return window_again


@pytest.mark.parametrize(("width", "height", "dpi"), [(5, 50, 300), (50, 2000, 300), (80, 60, 10), (1000, 1000, 2400)])
def test_invalid_figure_sizes_are_rejected(width, height, dpi):
    with pytest.raises(DisplayError, match="figure"):
        FigureSpec(width, height, dpi)


def test_unknown_file_types_are_rejected_without_writing(tmp_path, qapp):
    with pytest.raises(DisplayError, match=r"Choose \.svg, \.pdf or \.png"):
        write_figure(tmp_path / "a.gif", SMALL, "#ffffff", lambda painter: None)
    assert not list(tmp_path.iterdir())


def test_pens_of_a_png_have_their_width_on_paper(tmp_path, qapp):
    def paint(painter):
        painter.scale(0.5, 0.5)  # ignored by a cosmetic pen
        pen = painter.pen()
        pen.setWidthF(4.0)
        pen.setCosmetic(True)
        painter.setPen(pen)
        painter.drawLine(0, 40, 600, 40)

    for dpi in (96, 384):
        write_figure(tmp_path / "line.png", FigureSpec(40.0, 40.0, dpi), "#ffffff", paint)
        with Image.open(tmp_path / "line.png") as picture:
            column = [picture.getpixel((picture.width // 2, y))[0] < 128 for y in range(picture.height)]
        assert sum(column) == pytest.approx(4 * dpi / 96, abs=1)


def test_map_and_plots_are_vectors_of_the_given_size_and_the_window_is_unchanged(window, tmp_path):
    pixel = press_map(window, 70)
    run(window, 0.4)
    window.plots.draw()
    QApplication.processEvents()
    before = window.plots.grab().toImage()
    camera = window.map_view.camera
    figure = window.presenters.figure
    for part, spec in ((FigurePart.MAP, SMALL), (FigurePart.PLOTS, WIDE)):
        figure.save(part, tmp_path / f"{part.value}.svg", spec)
        text = (tmp_path / f"{part.value}.svg").read_text()
        assert f'width="{spec.width:g}mm" height="60mm"' in text
        assert text.count("<path") + text.count("<polyline") > 20
    drawn = (tmp_path / "map.svg").read_text()
    assert all(word in drawn for word in ("forearm", "Pressure (kPa)", "\u202fmm<"))
    touch = [Image.open(BytesIO(b64decode(data))) for data in re.findall(r"data:image/png;base64,([^\"]*)", drawn)]
    assert touch
    assert all(np.asarray(picture.convert("RGBA"))[..., 3].any() for picture in touch)
    plots = (tmp_path / "plots.svg").read_text()
    assert "image" not in re.sub(r"image-rendering", "", plots)
    half = WIDE.units[0] / 2
    places = [box.center().x() for box in text_boxes(plots).values()]
    assert 0 < min(places) < half < max(places) < 2 * half, "side by side"
    figure.save(FigurePart.PLOTS, tmp_path / "plots.pdf", SMALL)
    page = (tmp_path / "plots.pdf").read_bytes()
    assert b"/Type /Font" in page, "text can be searched and restyled"
    assert b"/Subtype /Image" not in page
    # A decompressor ignores what follows its data: a stream may end in a byte that looks like a line break.
    streams = re.findall(rb"stream\r?\n(x.*?)endstream", page, re.DOTALL)
    shown = b"".join(zlib.decompressobj().decompress(stream) for stream in streams)
    assert shown.count(b" Tj") + shown.count(b" TJ") > 10, "as text, not as outlines"
    found = re.search(rb"MediaBox \[0 0 ([\d.]+) ([\d.]+)", page)
    assert [float(side) / 72 * 25.4 for side in found.groups()] == pytest.approx([80, 60], abs=0.4)
    QApplication.processEvents()
    assert window.plots.grab().toImage() == before
    assert window.map_view.camera == camera
    left_release(window.map_view.viewport(), pixel)


def test_dialog_shows_pixels_stores_the_settings_and_the_robot_has_the_resolution(window, tmp_path, choose_file):
    choose_file("save_file", tmp_path / "robot.png")
    window.action("save_figure").trigger()
    dialog = window.presenters.figure.dialog
    dialog.part.setCurrentIndex(dialog.part.findData(FigurePart.ROBOT))
    dialog.width_mm.selectAll()
    QTest.keyClicks(dialog.width_mm, "5\t")
    assert dialog.note.text() == "A figure cannot have this width (found: 5 mm). Choose 20 to 1000 mm."
    assert not dialog.save.isEnabled()
    dialog.width_mm.setValue(80.0)
    dialog.height_mm.setValue(60.0)
    dialog.dpi.setValue(120)
    assert "378 × 283 pixels" in dialog.note.text()
    assert dialog.column.currentText() == "Other width"
    left_click(dialog.save)
    QApplication.processEvents()
    with Image.open(tmp_path / "robot.png") as picture:
        assert picture.size == (378, 283)
        assert picture.info["dpi"] == pytest.approx((120, 120), abs=0.1)
        ground = picture.convert("RGB").getpixel((picture.width // 2, 2))
        assert ground == (255, 255, 255)
        assert len(picture.convert("L").getcolors()) > 100, "the robot is drawn"
    assert "80 × 60" in window.notification_bar.text
    window.action("save_figure").trigger()
    again = window.presenters.figure.dialog
    assert (again.width_mm.value(), again.dpi.value(), again.part.currentData()) == (80.0, 120, FigurePart.ROBOT)
    again.reject()
    window.notification_bar.clear()


@pytest.mark.parametrize(("size", "shown"), [((40.0, 30.0), False), ((170.0, 85.0), True)])
def test_orientation_cube_of_a_small_figure_does_not_cover_the_robot(window, tmp_path, size, shown):
    window.presenters.figure.save(FigurePart.ROBOT, tmp_path / "robot.svg", FigureSpec(*size, 96))
    texts = text_boxes((tmp_path / "robot.svg").read_text())
    assert any(text.endswith("at the middle of the view") for text in texts)
    assert bool({"X", "Y", "Z"} & texts.keys()) is shown
    assert window.robot_view.display.overlay.cube_shown


@pytest.mark.long
def test_legend_of_arrows_is_in_the_corner_and_covers_no_part_of_the_robot(window, tmp_path):
    """It has no slider below it, as in the window, and is smaller in a small figure."""
    scales = {}
    for size in ((170.0, 85.0), (40.0, 30.0)):
        spec = FigureSpec(*size, 96)
        part = FigurePart.VIEWS if size[0] > 100 else FigurePart.ROBOT
        window.presenters.figure.save(part, tmp_path / "robot.svg", spec)
        drawn = (tmp_path / "robot.svg").read_text()
        page = QRectF(*map(float, re.search(r'viewBox="([^"]*)"', drawn)[1].split()))
        assert text_boxes(drawn)["Arrow: 12\u202fmm per newton"].bottom() > page.bottom() - 25
        scales[size] = page.width() / spec.units[0]
    assert scales[170.0, 85.0] == pytest.approx(1.0, abs=0.01)
    assert scales[40.0, 30.0] > 2.0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--figure", "map", "--mm", "3x3", "-o", "a.pdf"], "20 to 1000 mm"),
        (["--figure", "map", "--dpi", "1", "-o", "a.pdf"], "Choose 50 to 2400"),
        (["--figure", "map", "-o", "a.gif"], "Choose .svg, .pdf or .png"),
        (["-o", "a.txt"], "Choose a name ending in .png"),
    ],
)
def test_command_line_rejects_arguments_before_the_window_is_imported(capsys, tmp_path, monkeypatch, words, message):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, "tactile_widgets.window.application", None)  # which cannot be imported then
    assert main(["--robot", "nowhere.urdf", "screenshot", *words]) == 1
    assert message in capsys.readouterr().err


def test_picture_has_the_format_of_its_name_or_png():
    assert [check_picture_kind(name) for name in ("a", "a.png", "a.JPG")] == ["png", "png", "jpg"]


def transformed(drawn):
    """Transform and content of the groups of an SVG."""
    for matrix, content in re.findall(r'transform="matrix\(([^)]*)\)"[^>]*>(.*?)</g>', drawn, re.DOTALL):
        yield QTransform(*map(float, matrix.split(","))), content


def text_boxes(drawn, *, pixels=11):
    """Box of each text of an SVG, for a font of this size in units."""
    return dict(texts_with_boxes(drawn, pixels=pixels))


def texts_with_boxes(drawn, *, pixels=11):
    """All texts of an SVG, each with its box."""
    font = QFont(QApplication.font())
    font.setPixelSize(pixels)
    metrics = QFontMetricsF(font)
    pattern = r'<text [^>]* x="([-\d.]+)" y="([-\d.]+)"[^>]*>([^<]+)</text>'
    return [
        (text, view.mapRect(metrics.tightBoundingRect(text).translated(float(x), float(y))))
        for view, content in transformed(drawn)
        for x, y, text in re.findall(pattern, content)
        if not text.isspace()
    ]


def map_points(drawn):
    """Points of the outlines of patches: the polylines in scene units."""
    return [
        view.map(QPointF(float(x), float(y)))
        for view, content in transformed(drawn)
        if view.isScaling()
        for path in re.findall(r'<poly(?:line|gon) [^>]*points="([^"]*)"', content)
        for x, y in re.findall(r"([-\d.e]+),([-\d.e]+)", path)
    ]


@pytest.mark.parametrize("size", [(20.0, 20.0), (65.0, 50.0)])
def test_legend_of_a_small_figure_is_on_the_page_and_covers_neither_map_nor_colour_bar(window, tmp_path, size):
    window.presenters.view.set_base_layer(BaseLayer.AREA)
    window.presenters.figure.save(FigurePart.MAP, tmp_path / "map.svg", FigureSpec(*size))
    drawn = (tmp_path / "map.svg").read_text()
    page = QRectF(*map(float, re.search(r'viewBox="([^"]*)"', drawn)[1].split()))
    texts = text_boxes(drawn)
    assert {"Area distortion", "×2 or more", "Pressure (kPa)"} <= texts.keys()
    (overlaps,) = [box for text, box in texts.items() if text.endswith("0 overlaps")]
    assert all(page.contains(box) for box in texts.values())
    outlines = map_points(drawn)
    assert len(outlines) > 100
    assert all(page.contains(point) for point in outlines)
    legend = texts["Area distortion"].united(texts["×2 or more"]).united(overlaps)
    assert not any(legend.contains(point) for point in outlines)
    assert not any(legend.intersects(texts[text]) for text in ("Pressure (kPa)", "0", "forearm", "hand"))


def test_forces_in_a_small_figure_are_written_next_to_their_small_patches(window, small_arm, tmp_path):
    prepared = small_arm
    window.live.show_prepared(prepared)
    patches = np.array([prepared.skin.taxel_point(taxel).patch for taxel in range(len(prepared.skin))])
    middles = [np.flatnonzero(patches == patch)[(patches == patch).sum() // 2] for patch in np.unique(patches)]
    frame = touched(prepared.map, middles)
    shown = ShownInViews(window.views, prepared, None, ControlSettings(), frame)
    write_view_figure(shown, FigurePart.MAP, tmp_path / "map.svg", FigureSpec(40.0, 40.0))
    drawn = (tmp_path / "map.svg").read_text()
    forces = [box for text, box in text_boxes(drawn, pixels=13).items() if text.endswith("N")]
    assert len(forces) == len(middles)
    outlines = map_points(drawn)
    assert len(outlines) > 100
    assert not any(box.contains(point) for box in forces for point in outlines)


@pytest.mark.parametrize("size", [(50.0, 35.0), (60.0, 40.0)])
def test_names_in_a_small_figure_hide_no_border_of_a_patch(window, tmp_path, size):
    window.presenters.figure.save(FigurePart.MAP, tmp_path / "map.svg", FigureSpec(*size))
    drawn = (tmp_path / "map.svg").read_text()
    skin = window.live.prepared.skin
    names = {text: box for text, box in text_boxes(drawn).items() if text[:3] in {p.name[:3] for p in skin.patches}}
    assert len(names) == len(skin.patches)
    outlines = map_points(drawn)
    assert len(outlines) > 100
    assert not [name for name, box in names.items() if any(box.contains(point) for point in outlines)]


def test_captions_that_would_hide_a_patch_are_left_out_and_stated(window, small_arm, tmp_path, monkeypatch):
    """The force on the hand has room next to it, the name of the forearm has none."""
    window.live.show_prepared(small_arm)
    frame = touched(small_arm.map, [middle_taxel(small_arm.map, 2)])
    monkeypatch.setattr(type(window.live), "shown", property(lambda _live: frame))
    path = tmp_path / "map.svg"
    window.presenters.figure.write(FigurePart.MAP, path, FigureSpec(40.0, 40.0))
    drawn = path.read_text()
    texts = text_boxes(drawn)
    assert {"upper_arm", "hand"} <= texts.keys()
    assert "forearm" not in texts
    assert window.notification_bar.text.endswith(
        "Too small for forearm, which would hide patches; a larger figure shows them"
    )
    forces = {text: box for text, box in text_boxes(drawn, pixels=13).items() if text.endswith("N")}
    assert forces
    outlines = map_points(drawn)
    hidden = [text for text in ("upper_arm", "hand", *forces) for point in outlines if texts[text].contains(point)]
    assert not hidden
    assert window.map_view._painter.left_out == frozenset(), "the window is unchanged"
    window.presenters.figure.write(FigurePart.MAP, path, FigureSpec(120.0, 120.0))
    assert "forearm" in text_boxes(path.read_text())
    assert "Too small" not in window.notification_bar.text
