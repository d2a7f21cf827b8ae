"""Gymnasium knows the environments by name: on import, and with the package before the name."""

import subprocess
import sys
from pathlib import Path

import gymnasium
import pytest

from tactile_maps.learning import ENVIRONMENTS, register_environments

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_each_environment_is_registered_once(name):
    register_environments()
    assert gymnasium.spec(name).entry_point == ENVIRONMENTS[name]
    assert gymnasium.spec(name).max_episode_steps == 200


@pytest.mark.long
def test_environment_id_with_module_needs_no_import():
    code = "import gymnasium; print(gymnasium.make('tactile_maps.learning:TactileMaps-Follow-v0', taxels=60).spec.id)"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "TactileMaps-Follow-v0"


def test_missing_gymnasium_error_states_the_install_command():
    code = (
        "import sys; sys.modules['gymnasium.envs.registration'] = None\n"
        "from tactile_maps.core.errors import LearningError\n"
        "try:\n    import tactile_maps.learning\n"
        "except LearningError as error:\n    print(error.remedy)"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert f"{sys.executable} -m pip install 'gymnasium" in done.stdout
