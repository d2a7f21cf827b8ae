"""What the experiments are called, for those who need not load them; each is a file of that name."""

from __future__ import annotations

NAMES = (
    "map-cost",
    "image-cost",
    "touch-cost",
    "step-cost",
    "effect-cost",
    "control-cost",
    "control-laws",
    "control-theory",
)
