"""What a press on a view does with the tool in use: poke the skin, select taxels, edit, control. No Qt.

The tools are listed in ``tactile_widgets.tools.registry``; named here are only those that the views know by themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

SMALLEST_BRUSH = 6.0
BRUSH = 24.0
LARGEST_BRUSH = 160.0
"""Radius of the brush [px]."""
BRUSH_STEP = 1.25


class ToolRole(Enum):
    """What a press with a tool does."""

    POKE = "poke"
    SELECT = "select"
    EDIT = "edit"
    CONTROL = "control"


@dataclass(frozen=True)
class ToolKind:
    """A tool as the views know it.

    Attributes:
        name: Of the tool, and of the action that takes it.
        role: What a press with it does.
    """

    name: str
    role: ToolRole

    @property
    def selects(self) -> bool:
        """Whether it selects taxels, and so leaves the robot alone."""
        return self.role is ToolRole.SELECT

    @property
    def edits(self) -> bool:
        """Whether it edits the map, and so leaves the robot alone."""
        return self.role is ToolRole.EDIT

    @property
    def controls(self) -> bool:
        """Whether it says where the arm is to go."""
        return self.role is ToolRole.CONTROL

    @property
    def draws(self) -> bool:
        """Whether presses are a ``ViewTool``'s, and do not poke."""
        return self.edits or self.controls


POKE = ToolKind("poke", ToolRole.POKE)
SELECT_BOX = ToolKind("select_box", ToolRole.SELECT)
SELECT_LASSO = ToolKind("select_lasso", ToolRole.SELECT)
SELECT_BRUSH = ToolKind("select_brush", ToolRole.SELECT)


class SelectionMode(Enum):
    """What choosing taxels does to those chosen before."""

    REPLACE = "replace"
    ADD = "add"
    REMOVE = "remove"
    TOGGLE = "toggle"


def resized_brush(radius: float, steps: int) -> float:
    """The brush's radius [px] after so many steps larger, or smaller where negative."""
    return min(max(radius * BRUSH_STEP**steps, SMALLEST_BRUSH), LARGEST_BRUSH)
