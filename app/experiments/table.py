"""The experiments by name."""

from __future__ import annotations

from collections.abc import Mapping

from app.experiments import image_cost, map_cost
from app.experiments.experiment import Experiment

EXPERIMENTS: Mapping[str, Experiment] = {
    experiment.name: experiment for experiment in (map_cost.EXPERIMENT, image_cost.EXPERIMENT)
}
