"""Common setup of all tests: no display, one thread for linear algebra, and the choice of cases that run by default.

The tests of the default run take 430 to 800 CPU seconds, by the machine, and their collection 14 to 35 in each process.
Those above 0.3 s were chosen so that the listed mutations and, with few exceptions, all lines that any test executes
stay covered; other slow tests are marked ``long``.

    sh tests/run.sh          # the default: about ten minutes on two cores
    sh tests/run.sh --all    # everything: every case, more examples, the benchmarks once each, a real mouse
    pytest --cpu             # afterwards: CPU seconds by folder, by file and of the slowest tests

Tests that the default run omits are marked:

* ``@pytest.mark.long``: a test, or one case, that only ``--all`` runs, such as a sweep, a catalogue or a soak test.
* ``tests/benchmarks`` and ``tests/x11``, unless the folder is named.
* ``@pytest.mark.rotating``: every value of stacked ``parametrize`` marks runs once, combined with the others in turn;
  ``--all`` runs all combinations.
* ``@pytest.mark.sampled(n)``: ``n`` of the cases that are not long run, spread evenly over the list.
* ``examples(n)`` (``tests.support.examples``): Hypothesis tries a fifth as many.

The default run must detect every listed mutation of the code (``python -m tests.mutate``). A test that is named by its
node id always runs with all its cases.
"""

from __future__ import annotations

import os
import shutil
import signal
import sys
import tempfile
from pathlib import Path

# Pytest rewrites the assertions of each test module, and child processes compile what they import. Cache the results
# on disk even if the environment disables that; -B, as tests.mutate passes it, is respected.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False
# Set before NumPy is imported: two workers on two cores leave no core for a second thread.
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
if sys.platform == "linux":
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
os.environ.setdefault("QT_API", "pyside6")
# Child processes import the code under test, also in a copy of the checkout; pytest's own path is in pyproject.toml.
_ROOT = Path(__file__).resolve().parents[1]
os.environ["PYTHONPATH"] = os.pathsep.join(map(str, (_ROOT / "app", _ROOT / "widgets", _ROOT)))
# A run in the background or under nohup ignores the terminal's signals, and its child processes would inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if sys.platform == "win32":
    # These modules use signals or limits that Windows does not have.
    posix_only = ("amplified_files", "ending_signals", "interrupted", "interrupts", "listen_send", "small_bombs")
    collect_ignore_glob = [f"**/test_{name}.py" for name in posix_only]
else:
    for ignored in (signal.SIGHUP, signal.SIGQUIT):
        if signal.getsignal(ignored) is signal.SIG_IGN:
            signal.signal(ignored, signal.SIG_DFL)
# Each scene is prepared once in a run, by one of its processes. Tests do not use the user's cache.
if "PYTEST_XDIST_WORKER" not in os.environ:
    os.environ["TACTILE_MAPS_CACHE"] = tempfile.mkdtemp(prefix="tactile-maps-tests-")

pytest_plugins = [
    "tests.support.bounded_process",
    "tests.support.cpu_report",
    "tests.support.default_cases",
    "tests.support.patient_qtbot",
]


def pytest_unconfigure():
    """Delete the cache when the last process of the run ends."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        shutil.rmtree(os.environ["TACTILE_MAPS_CACHE"], ignore_errors=True)
