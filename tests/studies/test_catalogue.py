"""Studies are found by the names they have, and named without loading them."""

from __future__ import annotations

import subprocess
import sys

import pytest

from tactile_maps.core.errors import UsageError
from tactile_maps.studies.catalogue import load_study


def test_command_line_lists_studies_without_loading_them():
    code = "import sys; from tactile_maps.cli.parser import build_parser; build_parser(); print(sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'tactile_maps.studies.catalogue'" in loaded
    for heavy in ("numpy", "mujoco", "scipy", "tactile_maps.cli.commands.study"):
        assert f"'{heavy}'" not in loaded


def test_unknown_study_is_rejected_with_the_valid_names():
    with pytest.raises(UsageError, match="coffee-cost.*map-cost or image-cost"):
        load_study("coffee-cost")


@pytest.mark.long
def test_one_study_loads_no_other():
    code = (
        "import sys; from tactile_maps.studies.catalogue import load_study; "
        "load_study('image-cost'); print(sorted(sys.modules))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'tactile_maps.studies.sweeps.image_cost'" in loaded
    for other in (
        "tactile_maps.studies.path_time.representation",
        "tactile_maps.studies.sweeps.touch_cost",
        "matplotlib",
        "joblib",
    ):
        assert f"'{other}'" not in loaded
