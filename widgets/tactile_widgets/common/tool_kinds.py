"""Kinds of tools, by the effect of a press on a view: poke the skin, select taxels, edit, control. No Qt.

All tools are listed in ``tactile_widgets.tools.registry``; here are only those that the views handle themselves.
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
    """Effect of a press with a tool."""

    POKE = "poke"
    SELECT = "select"
    EDIT = "edit"
    CONTROL = "control"


@dataclass(frozen=True)
class ToolKind:
    """A tool as the views know it.

    Attributes:
        name: Name of the tool, and of the action that chooses it.
        role: Effect of a press.
    """

    name: str
    role: ToolRole

    @property
    def selects(self) -> bool:
        """True if it selects taxels and does not touch the robot."""
        return self.role is ToolRole.SELECT

    @property
    def edits(self) -> bool:
        """True if it edits the map and does not touch the robot."""
        return self.role is ToolRole.EDIT

    @property
    def controls(self) -> bool:
        """True if it sets goals of the controller."""
        return self.role is ToolRole.CONTROL

    @property
    def draws(self) -> bool:
        """True if a ``ViewTool`` handles presses, which do not poke."""
        return self.edits or self.controls


POKE = ToolKind("poke", ToolRole.POKE)
SELECT_BOX = ToolKind("select_box", ToolRole.SELECT)
SELECT_LASSO = ToolKind("select_lasso", ToolRole.SELECT)
SELECT_BRUSH = ToolKind("select_brush", ToolRole.SELECT)


class SelectionMode(Enum):
    """Effect of chosen taxels on the previous selection."""

    REPLACE = "replace"
    ADD = "add"
    REMOVE = "remove"
    TOGGLE = "toggle"


def resized_brush(radius: float, steps: int) -> float:
    """Return the radius of the brush [px] after a number of steps; negative steps make it smaller."""
    return min(max(radius * BRUSH_STEP**steps, SMALLEST_BRUSH), LARGEST_BRUSH)
