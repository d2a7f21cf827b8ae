"""What a layer of View > Overlay draws on the body: one protocol, so that the scene needs to know none by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from app.core.arrays import FloatArray
from app.session.frame import Frame
from app.session.prepare import PreparedScene
from widgets.common.colours import Theme


class BodyLayer(Protocol):
    """Actors of one layer, made once a scene. Hidden until a frame says where they are."""

    def show_frame(self, frame: Frame, poses: FloatArray) -> None:
        """Place them as of ``frame``; ``poses`` (links, 4, 4) are ``T_world_link``."""

    def set_shown(self, *, shown: bool) -> None:
        """Show them from the next ``show_frame`` on, which follows at once; or hide them now."""

    def hide(self) -> None:
        """Show nothing until the next ``show_frame``: the skin is off the body."""

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""


BodyLayerFactory = Callable[[Any, Theme, PreparedScene], BodyLayer]
"""Makes a layer on a plotter, for a scene."""
