"""The interface of sessions: what a simulation and readings of a real skin have in common."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Protocol

from tactile_maps.session.frame import Failure, Frame
from tactile_maps.session.input_log import InputLog
from tactile_maps.session.inputs import SessionInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings


class RunningSession(Protocol):
    """A session that runs tick by tick."""

    @property
    def prepared(self) -> PreparedScene:
        """Robot, skin, map and scene."""

    @property
    def frame(self) -> Frame:
        """State at the newest tick."""

    @property
    def inputs(self) -> InputLog:
        """Inputs since the reset; each with the tick of the first frame that shows it. A reset replaces the log."""

    @property
    def runtime_settings(self) -> RuntimeSettings:
        """Current settings."""

    @property
    def failure(self) -> Failure | None:
        """The failure that stopped the session; None while it can continue."""

    def submit(self, session_input: SessionInput) -> None:
        """Apply an input at the start of the next tick; raises TactileMapsError if it cannot be applied."""

    def tick(self) -> Frame:
        """Return the next frame; raises TactileMapsError if an input is rejected or the session fails."""

    def reset(self) -> None:
        """Start again with the current settings."""

    def watched(self, each: Callable[[Frame], None]) -> AbstractContextManager[None]:
        """Call ``each`` with every new frame while the block runs."""
