"""The machine is named."""

from __future__ import annotations

import numpy as np

from app.experiments.machine import describe


def test_processor_and_versions_are_told():
    machine = describe()
    assert machine["numpy"] == np.__version__
    assert int(machine["cores"]) >= 1
    assert all(isinstance(value, str) and value for value in machine.values())
    assert {"processor", "system", "Python", "tactile-maps", "libigl"} <= set(machine)
