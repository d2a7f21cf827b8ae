"""Mouse and keys on both views: who gets a press, what ends it, and what differs between robot and map."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QWidget

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.settings import NavigationStyle
from tactile_widgets.common.tool_kinds import SELECT_BOX, SELECT_BRUSH, SELECT_LASSO, ToolKind, ToolRole
from tactile_widgets.views.interaction.navigation import CameraMotion
from tactile_widgets.views.interaction.view_interaction import ViewInteraction
from tactile_widgets.views.interaction.view_tool import PointerHit, ViewTool

LEFT = Qt.MouseButton.LeftButton
MIDDLE = Qt.MouseButton.MiddleButton
SHIFT = Qt.KeyboardModifier.ShiftModifier
ALT = Qt.KeyboardModifier.AltModifier
NO_KEYS = Qt.KeyboardModifier.NoModifier
CONTROL_KEY = Qt.KeyboardModifier.ControlModifier
RIGHT = Qt.MouseButton.RightButton
SKIN = (10.0, 10.0)
OTHER_SKIN = (20.0, 10.0)
OFF_SKIN = (300.0, 300.0)
CONTROL = (500.0, 500.0)


class Board(QWidget):
    """A view with skin up to 100 pixels and a control from 400 on, that behaves as a map or as a body."""

    def __init__(self, *, is_map: bool) -> None:
        super().__init__()
        self.works_off_skin = is_map
        self.turns = not is_map
        self.idle_cursor = Qt.CursorShape.ArrowCursor
        self.did = []
        self.gestures = ViewInteraction(self, self)
        self.gestures.poke_pressed.connect(lambda at: self.did.append(("pressed", at.face)))
        self.gestures.poke_moved.connect(lambda at: self.did.append(("moved", at.face)))
        self.gestures.poke_pulled.connect(lambda at: self.did.append(("pulled", at.face)))
        self.gestures.poke_released.connect(lambda: self.did.append("released"))
        self.gestures.cleared.connect(lambda: self.did.append("cleared"))
        self.selector = self.gestures.taxel_selector
        self.selector.chosen.connect(lambda update: self.did.append(("chosen", update.taxels.tolist())))

    def point_at(self, pixel):
        return SurfacePoint(0, int(pixel.x()), (1.0, 0.0, 0.0)) if pixel.x() < 100 else None

    def hit_at(self, pixel, at):
        return PointerHit(at, np.zeros(2) if self.works_off_skin else None, 1.0)

    def empty_at(self, pixel):
        return 100 <= pixel.x() < 400

    def over_control(self, pixel):
        return pixel.x() >= 400

    def click_control(self, pixel):
        self.did.append("control")

    def navigate(self, step, motion):
        words = {CameraMotion.TURN: "turned", CameraMotion.PAN: "panned", CameraMotion.ZOOM: "zoomed"}
        self.did.append(words[motion])

    def frame_all(self):
        self.did.append("framed")

    def set_hover(self, at):
        pass

    def set_pointer(self, shape):
        self.pointer = shape

    def redraw_tool(self):
        pass

    def taxel_pixels(self):
        return np.array([SKIN, OTHER_SKIN])

    def hidden(self, taxels):
        return np.zeros(len(taxels), bool)

    def taxel_at(self, pixel):
        return 0 if pixel[0] < 100 else None

    def press(self, pixel, button=LEFT, keys=NO_KEYS):
        self.gestures.press(mouse(QEvent.Type.MouseButtonPress, pixel, button, keys))

    def move(self, pixel, keys=NO_KEYS):
        self.gestures.move(mouse(QEvent.Type.MouseMove, pixel, Qt.MouseButton.NoButton, keys))

    def release(self, pixel, button=LEFT):
        self.gestures.release(mouse(QEvent.Type.MouseButtonRelease, pixel, button, NO_KEYS))

    def drag(self, start, end, button=LEFT, keys=NO_KEYS):
        self.press(start, button, keys)
        self.move(end)
        self.release(end, button)

    def key(self, key):
        return self.gestures.key(QKeyEvent(QEvent.Type.KeyPress, key, NO_KEYS))


def mouse(kind, pixel, button, keys):
    return QMouseEvent(kind, QPointF(*pixel), QPointF(*pixel), button, button, keys)


class Pen(ViewTool):
    """Tool that handles every press and records the calls."""

    def __init__(self, did):
        super().__init__()
        self.did = did
        self.open = False

    def press(self, place, event):
        self.did.append("drew")
        self.open = True
        return True

    def release(self, place, event):
        self.did.append("lifted")

    def cancel(self):
        was = self.open
        self.open = False
        return was


@pytest.fixture(params=["map", "body"])
def board(request, qtbot):
    made = Board(is_map=request.param == "map")
    qtbot.addWidget(made)
    return made


@pytest.fixture
def moved(board):
    """Effect of a drag that moves the view."""
    return "turned" if board.turns else "panned"


def test_alt_pulls_the_finger_instead_of_moving_it(board):
    board.press(SKIN)
    board.move(OTHER_SKIN, keys=ALT)
    board.release(OTHER_SKIN)
    assert board.did == [("pressed", 10), ("pulled", 20), "released"]


def test_press_on_skin_pokes_and_strokes_until_its_button_is_released(board):
    board.press(SKIN)
    board.press(OTHER_SKIN, MIDDLE)
    board.release(OTHER_SKIN, MIDDLE)
    assert board.did == [("pressed", 10)], "one gesture at a time"
    board.move(OFF_SKIN)
    board.move(SKIN)
    assert len(board.did) == 1, "the finger stays where the pointer left the skin"
    board.move(OTHER_SKIN)
    board.release(OTHER_SKIN)
    assert board.did == [("pressed", 10), ("moved", 20), "released"]
    assert not board.gestures.busy
    board.move(SKIN)
    assert len(board.did) == 3


def test_losing_the_focus_lifts_the_finger_once(board):
    board.press(SKIN)
    board.gestures.focus_out()
    board.gestures.focus_out()
    board.release(SKIN)
    assert board.did == [("pressed", 10), "released"]


@pytest.mark.parametrize(
    ("start", "button", "keys", "pans"),
    [
        pytest.param(OFF_SKIN, LEFT, NO_KEYS, False, id="off skin"),
        pytest.param(SKIN, RIGHT, NO_KEYS, False, id="right"),
        pytest.param(SKIN, LEFT, CONTROL_KEY, False, id="control"),
        pytest.param(SKIN, LEFT, SHIFT, True, id="shift"),
        pytest.param(SKIN, MIDDLE, NO_KEYS, True, id="middle"),
    ],
)
def test_drags_with_buttons_and_keys_move_the_view(board, moved, start, button, keys, pans):
    board.drag(start, OTHER_SKIN, button, keys)
    assert board.did == ["panned" if pans else moved]


@pytest.mark.parametrize(
    ("style", "button", "keys", "expected"),
    [
        (NavigationStyle.MUJOCO, RIGHT, NO_KEYS, "panned"),
        (NavigationStyle.MUJOCO, MIDDLE, NO_KEYS, "zoomed"),
        (NavigationStyle.BLENDER, MIDDLE, NO_KEYS, None),
        (NavigationStyle.BLENDER, MIDDLE, SHIFT, "panned"),
        (NavigationStyle.BLENDER, MIDDLE, CONTROL_KEY, "zoomed"),
    ],
)
def test_style_selects_the_buttons_that_move_the_view(board, moved, style, button, keys, expected):
    board.gestures.style = style
    board.drag(SKIN, OTHER_SKIN, button, keys)
    assert board.did == [expected or moved]


def test_space_pans_during_a_drag_and_triggers_its_action_otherwise(board):
    board.gestures.space_tapped.connect(lambda: board.did.append("tapped"))
    up = QKeyEvent(QEvent.Type.KeyRelease, Qt.Key.Key_Space, NO_KEYS)
    assert board.key(Qt.Key.Key_Space)
    assert board.pointer == Qt.CursorShape.OpenHandCursor
    board.gestures.key_up(up)
    assert board.did == ["tapped"]
    board.key(Qt.Key.Key_Space)
    board.drag(SKIN, OTHER_SKIN)
    board.gestures.key_up(up)
    assert board.did == ["tapped", "panned"]


def test_shift_click_on_skin_requests_a_latch_and_right_click_the_menu(board, moved):
    """A few pixels of trembling do not make a drag."""
    board.gestures.latch_requested.connect(lambda at: board.did.append(("latched", at.face)))
    board.gestures.menu_requested.connect(lambda pixel: board.did.append(pixel.toTuple()))
    near = (12.0, 11.0)
    board.drag(SKIN, near, LEFT, SHIFT)
    board.drag(OFF_SKIN, OFF_SKIN, LEFT, SHIFT)
    assert board.did == [("latched", 10)], "next to the skin there is nothing to press"
    board.drag(SKIN, near, RIGHT)
    board.drag(OFF_SKIN, OFF_SKIN, RIGHT)
    assert board.did[1:] == [SKIN, OFF_SKIN]
    board.drag(SKIN, OTHER_SKIN, RIGHT)
    assert board.did[3:] == [moved]


def test_control_in_the_view_receives_its_clicks(board):
    board.move(CONTROL)
    assert board.pointer == Qt.CursorShape.PointingHandCursor
    board.drag(CONTROL, CONTROL)
    assert board.did == ["control"]
    assert not board.gestures.busy


def test_tool_owns_the_mouse_until_the_release_and_escape_cancels_its_gesture(board):
    board.gestures.set_tool(ToolKind("pins", ToolRole.EDIT))
    board.gestures.set_view_tool(Pen(board.did))
    board.press(SKIN)
    assert board.gestures.editing
    assert board.gestures.hover is None
    board.press(OTHER_SKIN, MIDDLE)
    board.release(OTHER_SKIN)
    assert board.did == ["drew", "lifted"]
    assert board.gestures.hover is not None
    board.press(SKIN)
    assert board.key(Qt.Key.Key_Escape)
    assert not board.gestures.editing
    assert "cleared" not in board.did
    board.key(Qt.Key.Key_Escape)
    assert board.did[-1] == "cleared"
    board.gestures.set_view_tool(None)


def test_drawing_made_click_by_click_outlives_the_focus_but_not_another_tool(board):
    pen = Pen(board.did)
    board.gestures.set_tool(ToolKind("draw_path", ToolRole.CONTROL))
    board.gestures.set_view_tool(pen)
    board.drag(SKIN, SKIN)
    board.gestures.focus_out()
    assert pen.open
    board.gestures.set_view_tool(None)
    assert not pen.open


def test_double_click_fits_the_view_off_skin_and_pokes_on_skin(board):
    board.gestures.double_click(mouse(QEvent.Type.MouseButtonDblClick, OFF_SKIN, LEFT, NO_KEYS))
    board.gestures.double_click(mouse(QEvent.Type.MouseButtonDblClick, SKIN, LEFT, NO_KEYS))
    assert board.did == ["framed", ("pressed", 10)]
    board.release(SKIN)


# Selection.


def corners(board):
    return board.selector.rubber_band.outline.tolist()


def test_click_selects_a_taxel_and_a_box_starts_off_skin_only_on_the_map(board, moved):
    board.gestures.set_tool(SELECT_BOX)
    board.press(SKIN)
    board.move((13.0, 10.0))
    board.release((13.0, 10.0))
    assert board.did == [("chosen", [0])], "a few pixels of trembling do not make a drag"
    board.drag(OFF_SKIN, (0.0, 0.0))
    assert board.did[1] == (moved if board.turns else ("chosen", [0, 1]))


@pytest.mark.parametrize(
    ("keys", "mode"),
    [(CONTROL_KEY, "toggle"), (SHIFT, "toggle"), (Qt.KeyboardModifier.AltModifier, "remove"), (NO_KEYS, "replace")],
)
def test_click_with_a_key_that_adds_toggles(board, keys, mode):
    modes = []
    board.gestures.set_tool(SELECT_BOX)
    board.selector.chosen.connect(lambda update: modes.append(update.change.value))
    board.drag(SKIN, SKIN, LEFT, keys)
    assert modes == [mode]


@pytest.mark.parametrize("tool", [SELECT_BOX, SELECT_LASSO, SELECT_BRUSH])
def test_press_that_moved_and_returned_is_not_a_click(board, tool):
    board.gestures.set_tool(tool)
    board.press(OTHER_SKIN)
    board.move((60.0, 90.0))
    board.move(OTHER_SKIN)
    before = len(board.did)
    board.release(OTHER_SKIN)
    assert len(board.did) == before


def test_box_spans_from_press_to_pointer_and_lasso_follows_it(board):
    board.gestures.set_tool(SELECT_BOX)
    board.press((10.0, 20.0))
    board.move((40.0, 60.0))
    board.move((5.0, 30.0))
    assert corners(board) == [[10, 20], [5, 20], [5, 30], [10, 30]]
    board.release((5.0, 30.0), RIGHT)
    assert board.selector.busy, "another button"
    board.release((5.0, 30.0))
    assert board.selector.rubber_band.outline is None
    board.gestures.set_tool(SELECT_LASSO)
    board.press((0.0, 0.0))
    for pixel in ((10.0, 0.0), (10.5, 0.0), (10.0, 10.0)):
        board.move(pixel)
    assert corners(board) == [[0, 0], [10, 0], [10, 10]], "steps below two pixels are skipped"


def test_brush_selects_from_the_press_on_and_along_each_stretch(board):
    board.gestures.set_tool(SELECT_BRUSH)
    board.selector.set_radius(6.0)
    board.press((8.0, 10.0))
    assert board.did == [("chosen", [0])]
    board.move((60.0, 60.0))
    assert board.did == [("chosen", [0])]
    board.move((20.0, 4.0))
    assert board.did[1:] == [("chosen", [0, 1])]
    assert board.selector.rubber_band.outline is None


def test_cancelled_drag_is_discarded_and_cancelled_press_is_not_a_click(board):
    abandoned = []
    board.gestures.set_tool(SELECT_BOX)
    board.selector.abandoned.connect(lambda: abandoned.append(True))
    board.press(SKIN)
    board.gestures.cancel()
    board.release(SKIN)
    assert (board.did, abandoned) == ([], [])
    board.press(SKIN)
    board.move((50.0, 50.0))
    board.gestures.cancel()
    assert abandoned == [True]
    board.move((60.0, 60.0))
    assert board.selector.rubber_band.outline is None
