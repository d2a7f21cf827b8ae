"""Each law's own gains: remembered while another law is tried, and put back to where they began. No Qt."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, cast

from app.control.command import ControlSettings, LawName

GAINS = (
    "stiffness", "damping_ratio", "force_gain", "integral_time", "position_gain", "gains", "inertia_time", "jacobian",
)  # fmt: skip
"""Settings that say how a law works; the others say what it is to do."""


class GainMemory:
    """Gains by law. Mutable: ``switched`` and ``begin``.

    Attributes:
        defaults: Where gains began, and go back to.
    """

    def __init__(self) -> None:
        self.begin(ControlSettings())

    def begin(self, defaults: ControlSettings) -> None:
        """Another scene: forget the gains of the one before."""
        self.defaults = defaults
        self._known: dict[str, dict[str, Any]] = {}

    def switched(self, settings: ControlSettings, law: str) -> ControlSettings:
        """The settings with another law: with the gains it had when it was last in force, else with those of now."""
        self._known[settings.law] = {name: getattr(settings, name) for name in GAINS}
        return replace(settings, law=cast("LawName", law), **self._known.get(law, {}))

    def reset(self, settings: ControlSettings) -> ControlSettings:
        """The settings with all gains where they began."""
        began: dict[str, Any] = {name: getattr(self.defaults, name) for name in GAINS}
        return replace(settings, **began)
