"""What all marks on the body share: they ride on links, wear a theme, and are hidden while the skin is off the body."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import Any

from app.session.prepare import Prepared
from widgets.colours import Theme
from widgets.robot_view.flat_shapes import line_width


class LinkMarks(ABC):
    """Actors a patch, in the frame of its link. Mutable.

    Args:
        theme: Of their colours.
        prepared: Whose skin is marked.

    Attributes:
        riders: Link number and actor of all that moves with a link.
    """

    def __init__(self, theme: Theme, prepared: Prepared) -> None:
        self._theme, self._skin, self._hidden = theme, prepared.skin, False
        self._width = line_width(prepared.skin)
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        self.riders: list[tuple[int, Any]] = []

    def _ride(self, kinds: Iterable[Sequence[Any]]) -> None:
        """Let actors, one a patch of each kind, move with their links."""
        self.riders = [pair for kind in kinds for pair in zip(self._links, kind, strict=True)]

    def hide(self, *, hidden: bool) -> None:
        """Hide everything while the skin is off the body, or show it again."""
        self._hidden = hidden
        self._draw()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._draw()

    @abstractmethod
    def _draw(self) -> None:
        """Draw all of it anew."""
