"""The hand on a view, the same on robot and map: who gets a press, what ends it, and what only one of them does."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QWidget

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.tool_kinds import SELECT_BOX, ToolKind, ToolRole
from tactile_widgets.views.interaction.view_interaction import ViewInteraction
from tactile_widgets.views.interaction.view_tool import PointerHit, ViewTool

LEFT = Qt.MouseButton.LeftButton
MIDDLE = Qt.MouseButton.MiddleButton
SHIFT = Qt.KeyboardModifier.ShiftModifier
NO_KEYS = Qt.KeyboardModifier.NoModifier
CONTROL_KEY = Qt.KeyboardModifier.ControlModifier
RIGHT = Qt.MouseButton.RightButton
SKIN = (10.0, 10.0)
OTHER_SKIN = (20.0, 10.0)
BESIDE = (300.0, 300.0)
CONTROL = (500.0, 500.0)


class Board(QWidget):
    """A view with skin up to 100 pixels and a control from 400 on; a map or a body as its policy says."""

    def __init__(self, *, is_map: bool) -> None:
        super().__init__()
        self.beside_skin = is_map
        self.turns = not is_map
        self.idle_cursor = Qt.CursorShape.ArrowCursor
        self.did = []
        self.hand = ViewInteraction(self, self)
        self.hand.poke_pressed.connect(lambda at: self.did.append(("pressed", at.face)))
        self.hand.poke_moved.connect(lambda at: self.did.append(("moved", at.face)))
        self.hand.poke_released.connect(lambda: self.did.append("released"))
        self.hand.cleared.connect(lambda: self.did.append("cleared"))
        self.hand.taxel_selector.chosen.connect(lambda update: self.did.append(("chosen", update.taxels.tolist())))

    def point_at(self, pixel):
        return SurfacePoint(0, int(pixel.x()), (1.0, 0.0, 0.0)) if pixel.x() < 100 else None

    def hit_at(self, pixel, at):
        return PointerHit(at, np.zeros(2) if self.beside_skin else None, 1.0)

    def empty_at(self, pixel):
        return 100 <= pixel.x() < 400

    def over_control(self, pixel):
        return pixel.x() >= 400

    def click_control(self, pixel):
        self.did.append("control")

    def navigate(self, drag, *, turn):
        self.did.append("turned" if turn else "panned")

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

    # The hand.

    def press(self, pixel, button=LEFT, keys=NO_KEYS):
        self.hand.press(mouse(QEvent.Type.MouseButtonPress, pixel, button, keys))

    def move(self, pixel):
        self.hand.move(mouse(QEvent.Type.MouseMove, pixel, Qt.MouseButton.NoButton, NO_KEYS))

    def release(self, pixel, button=LEFT):
        self.hand.release(mouse(QEvent.Type.MouseButtonRelease, pixel, button, NO_KEYS))

    def drag(self, start, end, button=LEFT, keys=NO_KEYS):
        self.press(start, button, keys)
        self.move(end)
        self.release(end, button)

    def key(self, key):
        return self.hand.key(QKeyEvent(QEvent.Type.KeyPress, key, NO_KEYS))


def mouse(kind, pixel, button, keys):
    return QMouseEvent(kind, QPointF(*pixel), QPointF(*pixel), button, button, keys)


class Pen(ViewTool):
    """Takes every press; remembers what it was told."""

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


def test_a_press_on_the_skin_pokes_and_strokes_until_the_button_comes_up(board):
    board.drag(SKIN, OTHER_SKIN)
    assert board.did == [("pressed", 10), ("moved", 20), "released"]
    assert not board.hand.busy


def test_beside_the_skin_the_view_moves(board):
    board.drag(BESIDE, SKIN)
    assert board.did == ["turned" if board.turns else "panned"]


@pytest.mark.parametrize("how", ["middle", "space"])
def test_the_middle_button_and_space_pan_on_the_skin_too(board, how):
    if how == "space":
        assert board.key(Qt.Key.Key_Space)
        assert board.pointer == Qt.CursorShape.OpenHandCursor
    board.drag(SKIN, OTHER_SKIN, MIDDLE if how == "middle" else LEFT)
    assert board.did == ["panned"]


def test_space_alone_is_a_tap_and_with_a_drag_is_none(board):
    board.hand.space_tapped.connect(lambda: board.did.append("tapped"))
    up = QKeyEvent(QEvent.Type.KeyRelease, Qt.Key.Key_Space, NO_KEYS)
    board.key(Qt.Key.Key_Space)
    board.hand.key_up(up)
    assert board.did == ["tapped"]
    board.key(Qt.Key.Key_Space)
    board.drag(SKIN, OTHER_SKIN)
    board.hand.key_up(up)
    assert board.did == ["tapped", "panned"]


@pytest.mark.parametrize(("button", "keys"), [(RIGHT, NO_KEYS), (LEFT, CONTROL_KEY)])
def test_the_right_button_and_control_turn_over_the_skin_too(board, button, keys):
    """Zoomed in there is no place beside it."""
    board.drag(SKIN, OTHER_SKIN, button, keys)
    assert board.did == ["turned" if board.turns else "panned"]


def test_shift_pans_over_the_skin_and_a_click_with_it_leaves_a_finger_there(board):
    board.hand.latch_requested.connect(lambda at: board.did.append(("latched", at.face)))
    board.drag(SKIN, OTHER_SKIN, LEFT, SHIFT)
    assert board.did == ["panned"]
    board.drag(SKIN, (12.0, 11.0), LEFT, SHIFT)
    assert board.did == ["panned", ("latched", 10)]
    board.drag(BESIDE, BESIDE, LEFT, SHIFT)
    assert len(board.did) == 2, "beside the skin there is nothing to press"


def test_a_right_click_asks_for_the_menu_and_a_right_drag_does_not(board):
    board.hand.menu_requested.connect(lambda pixel: board.did.append(pixel.toTuple()))
    board.drag(SKIN, (12.0, 11.0), RIGHT)
    assert board.did == [SKIN], "a hand that trembles turns nothing"
    board.drag(SKIN, OTHER_SKIN, RIGHT)
    assert board.did[1:] == ["turned" if board.turns else "panned"]
    board.drag(BESIDE, BESIDE, RIGHT)
    assert board.did[2:] == [BESIDE]


def test_a_control_takes_its_clicks(board):
    board.move(CONTROL)
    assert board.pointer == Qt.CursorShape.PointingHandCursor
    board.press(CONTROL)
    board.release(CONTROL)
    assert board.did == ["control"]
    assert not board.hand.busy


def test_only_one_gesture_at_a_time(board):
    board.press(SKIN)
    board.press(OTHER_SKIN, MIDDLE)
    board.release(OTHER_SKIN, MIDDLE)
    assert board.did == [("pressed", 10)]
    board.release(SKIN)
    assert board.did[-1] == "released"


def test_selecting_leaves_the_skin_alone_and_begins_beside_it_on_a_map_only(board):
    board.hand.set_tool(SELECT_BOX)
    board.press(SKIN)
    board.release(SKIN)
    assert board.did == [("chosen", [0])]
    board.drag(BESIDE, (0.0, 0.0))
    assert board.did[1] == ("turned" if board.turns else ("chosen", [0, 1]))


def test_a_tool_owns_the_mouse_until_the_release_and_escape_gives_its_gesture_up(board):
    board.hand.set_tool(ToolKind("pins", ToolRole.EDIT))
    board.hand.set_view_tool(Pen(board.did))
    board.press(SKIN)
    assert board.hand.editing
    assert board.hand.hover is None
    board.press(OTHER_SKIN, MIDDLE)
    board.release(OTHER_SKIN)
    assert board.did == ["drew", "lifted"]
    assert board.hand.hover is not None
    board.press(SKIN)
    assert board.key(Qt.Key.Key_Escape)
    assert not board.hand.editing
    assert "cleared" not in board.did
    board.key(Qt.Key.Key_Escape)
    assert board.did[-1] == "cleared"
    board.hand.set_view_tool(None)


def test_what_is_drawn_click_by_click_outlives_the_focus_but_not_another_tool(board):
    pen = Pen(board.did)
    board.hand.set_tool(ToolKind("draw_path", ToolRole.CONTROL))
    board.hand.set_view_tool(pen)
    board.press(SKIN)
    board.release(SKIN)
    board.hand.focus_out()
    assert pen.open
    board.hand.set_view_tool(None)
    assert not pen.open


def test_a_finger_never_stays_pressed_where_no_hand_can_lift_it(board):
    board.press(SKIN)
    board.hand.focus_out()
    assert board.did == [("pressed", 10), "released"]
    board.release(SKIN)
    assert len(board.did) == 2


def test_a_double_click_frames_all_beside_the_skin_and_is_one_more_press_on_it(board):
    board.hand.double_click(mouse(QEvent.Type.MouseButtonDblClick, BESIDE, LEFT, NO_KEYS))
    assert board.did == ["framed"]
    board.hand.double_click(mouse(QEvent.Type.MouseButtonDblClick, SKIN, LEFT, NO_KEYS))
    assert board.did[1:] == [("pressed", 10)]
    board.release(SKIN)
