"""Studies are found by the names they have, and named without loading them."""

from __future__ import annotations

import subprocess
import sys

from app.cli.study_command import STUDIES
from app.studies.catalogue import STUDY_NAMES


def test_names_differ():
    assert len(set(STUDY_NAMES)) == len(STUDY_NAMES) >= 3
    assert "touch-cost" in STUDY_NAMES


def test_the_command_line_knows_them_and_stays_light():
    code = "import sys; from app.cli.parser import build_parser; build_parser(); print(sorted(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert "'app.studies.catalogue'" in loaded
    for heavy in ("numpy", "mujoco", "scipy", "app.cli.study_command"):
        assert f"'{heavy}'" not in loaded


def test_a_study_has_the_name_it_is_found_by():
    assert list(STUDIES) == list(STUDY_NAMES)
    for name, study in STUDIES.items():
        assert study.name == name
        assert study.question.endswith("?")
        assert study.cases(True, 0)
        assert len(study.cases(True, 0)) < len(study.cases(False, 0))
