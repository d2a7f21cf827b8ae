"""Table of the builders."""

from __future__ import annotations

from tactile_maps.maps.learned import (
    geodesic_information,
    human_touch,
    information_distance,
    self_organising,
    temporal_correlation,
)
from tactile_maps.maps.learned.learned_map import Builder

LEARNING_METHODS: dict[str, Builder] = {
    module.NAME: module.build
    for module in (information_distance, geodesic_information, temporal_correlation, human_touch, self_organising)
}
"""Methods of learning a map from touch; each takes readings and returns a ``LearnedMap``."""
