"""The studies by name, for those who need not load them; each is a file of that name in ``sweeps``."""

from __future__ import annotations

STUDY_NAMES = (
    "map-cost",
    "image-cost",
    "touch-cost",
    "step-cost",
    "effect-cost",
    "control-cost",
    "controller-accuracy",
)
