"""What the hand does with a press on a view: poke the skin, choose taxels in one of three ways, edit, lead. No Qt."""

from __future__ import annotations

from enum import Enum

SMALLEST_BRUSH, BRUSH, LARGEST_BRUSH = 6.0, 24.0, 160.0
"""Radius of the brush [px]."""
BRUSH_STEP = 1.25


class ToolKind(Enum):
    """The tool in the hand; each value is the name of the action that takes it."""

    POKE = "poke"
    BOX = "select_box"
    LASSO = "select_lasso"
    BRUSH = "select_brush"
    ARRANGE = "arrange"
    PINS = "pins"
    SEAMS = "seams"
    INTEREST = "interest"
    PATH = "draw_path"
    TARGET = "set_target"

    @property
    def chooses(self) -> bool:
        """Whether it chooses taxels, and so leaves the robot alone."""
        return self in (ToolKind.BOX, ToolKind.LASSO, ToolKind.BRUSH)

    @property
    def edits(self) -> bool:
        """Whether it edits the map, and so leaves the robot alone."""
        return self in (ToolKind.ARRANGE, ToolKind.PINS, ToolKind.SEAMS, ToolKind.INTEREST)

    @property
    def leads(self) -> bool:
        """Whether it tells the arm where to go."""
        return self in (ToolKind.PATH, ToolKind.TARGET)

    @property
    def draws(self) -> bool:
        """Whether presses are an ``EditTool``'s, and do not poke."""
        return self.edits or self.leads


class SelectionMode(Enum):
    """What choosing taxels does to those chosen before."""

    REPLACE = "replace"
    ADD = "add"
    REMOVE = "remove"
    TOGGLE = "toggle"


def resized_brush(radius: float, steps: int) -> float:
    """The brush's radius [px] after so many steps larger, or smaller where negative."""
    return min(max(radius * BRUSH_STEP**steps, SMALLEST_BRUSH), LARGEST_BRUSH)
