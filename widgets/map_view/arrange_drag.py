"""What dragging does to the selected patches: from where the hand is to an edit of the document, and what is shown."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from app.arrays import FloatArray
from app.editing.arrange import move, rotate, scale
from app.editing.document import MapDocument
from app.editing.snap import Snap, snap_move
from widgets.map_view.arrange_frame import ArrangeFrame, possible_scale, stepped_turn
from widgets.map_view.arrange_marks import ArrangeMarks

SNAP_PX = 8.0

Edit = Callable[[MapDocument], MapDocument]


class Act(Enum):
    """What a drag does; each value is the step's name."""

    MOVE = "Move"
    SCALE = "Scale"
    TURN = "Turn"
    BOX = "Select"


@dataclass(frozen=True, eq=False)
class Grip:
    """What the hand holds, as it was at the press.

    Attributes:
        act: What dragging does.
        document: As it was.
        numbers: The patches to be edited.
        frame: Around them.
        start: (2,) where it was pressed [m].
        corner: The frame's corner that is held, for scaling.
    """

    act: Act
    document: MapDocument
    numbers: tuple[int, ...]
    frame: ArrangeFrame
    start: FloatArray
    corner: int


def dragged(
    grip: Grip, point: FloatArray, pixel: float, *, shift: bool = False, control: bool = False
) -> tuple[Edit, ArrangeMarks]:
    """The edit of the document as it was at the press, for a hand that is at ``point`` now.

    Args:
        grip: What it holds.
        point: (2,) on the map [m].
        pixel: Size of a pixel [m].
        shift: Move along one axis, scale about the middle, turn by whole steps.
        control: Do not snap.
    """
    if grip.act is Act.SCALE:
        return _scaled(grip, point - grip.start, from_middle=shift)
    if grip.act is Act.TURN:
        return _turned(grip, point, stepped=shift)
    return _moved(grip, point - grip.start, reach=0.0 if control else SNAP_PX * pixel, straight=shift)


def _moved(grip: Grip, by: FloatArray, *, reach: float, straight: bool) -> tuple[Edit, ArrangeMarks]:
    snap = snap_move(grip.document, grip.numbers, by, reach=reach)
    if straight:
        along = int(np.abs(by).argmax())
        step = np.array(by) * [along == 0, along == 1]
        met = snap_move(grip.document, grip.numbers, step, reach=reach)
        snap = Snap((met.by[0], 0.0), x=met.x) if along == 0 else Snap((0.0, met.by[1]), y=met.y)
    words = _signed(f"x {1e3 * snap.by[0]:+.1f}, y {1e3 * snap.by[1]:+.1f}\u2009mm")
    marks = ArrangeMarks(grip.frame.moved(snap.by), snap.x, snap.y, words=words)
    return partial(move, numbers=grip.numbers, by=snap.by), marks


def _scaled(grip: Grip, by: FloatArray, *, from_middle: bool) -> tuple[Edit, ArrangeMarks]:
    wanted, about = grip.frame.pulled(grip.corner, by, from_middle=from_middle)
    factor = possible_scale(grip.document, grip.numbers, wanted)
    words = f"×{factor:.2f}"
    before = grip.document.layout.placements[grip.numbers[0]].scale
    if len(grip.numbers) == 1 and before != 1:
        words += f", ×{factor * before:.2f} of true size"
    marks = ArrangeMarks(grip.frame.scaled(factor, about), words=words)
    return partial(scale, numbers=grip.numbers, factor=factor, about=about), marks


def _turned(grip: Grip, point: FloatArray, *, stepped: bool) -> tuple[Edit, ArrangeMarks]:
    angle = grip.frame.swung(grip.start, point)
    if stepped:
        angle = stepped_turn(grip.document, grip.numbers, angle)
    marks = ArrangeMarks(grip.frame.turned(angle), words=_signed(f"{np.degrees(angle):+.1f}°"))
    return partial(rotate, numbers=grip.numbers, angle=angle, about=grip.frame.middle), marks


def _signed(words: str) -> str:
    """With a minus sign as wide as the plus, so that nothing jitters."""
    return words.replace("-", "\u2212")
