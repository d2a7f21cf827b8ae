from .as_tactile_map import learned_tactile_map
from .learned_map import Builder, LearnedMap
from .methods import LEARNING_METHODS

__all__ = [
    "LEARNING_METHODS",
    "Builder",
    "LearnedMap",
    "learned_tactile_map",
]
