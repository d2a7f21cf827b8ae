"""The experiments by name."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module

from app.experiments.experiment import Experiment
from app.experiments.names import NAMES

EXPERIMENTS: Mapping[str, Experiment] = {
    name: import_module(f"app.experiments.{name.replace('-', '_')}").EXPERIMENT for name in NAMES
}
