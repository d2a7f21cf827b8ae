"""What every test stands on: no screen, one thread for linear algebra, and which cases run by default.

    sh tests/run.sh          # the default: at most eight minutes on two cores
    sh tests/run.sh --all    # everything: every case, more examples, the benchmarks once each, a real mouse
    pytest --cpu             # afterwards: CPU seconds by folder, by file and of the dearest tests

What the default leaves out is marked:

* ``@pytest.mark.long``: a test, or one case, that only ``--all`` runs: a sweep, a catalogue, a soak.
* ``tests/benchmarks`` and ``tests/x11``, unless the folder is named.
* ``@pytest.mark.rotating``: of stacked ``parametrize`` every value runs, each with one value of the others in turn; all
  combinations only in ``--all``.
* ``@pytest.mark.sampled(n)``: of many cases ``n`` run, spread evenly over the list.
* ``examples(n)`` (``tests.support.examples``): hypothesis tries a fifth as many.

What a mutation of the code would break must break in the default (``python -m tests.mutate``). Where a test is named by
its node id, nothing is left out.
"""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

# Of every test module pytest rewrites the assertions, and each process that tests start compiles what it imports: to
# do it once, keep it on disk even where the environment says not to. Whoever passes -B, like tests.mutate, means it.
if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    sys.dont_write_bytecode = False
# Before NumPy: two workers on two cores leave no core for a second thread.
for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
if sys.platform == "linux":
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
os.environ.setdefault("QT_API", "pyside6")
# Processes that tests start run the code under test, in a copy of the checkout too; pytest's own path is in pyproject.
_ROOT = Path(__file__).resolve().parents[1]
os.environ["PYTHONPATH"] = os.pathsep.join(map(str, (_ROOT / "app", _ROOT / "widgets", _ROOT)))
# A run in the background or under nohup ignores signals of a terminal, and so would every process that a test ends.
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
# What a test prepares is made by the code as it is in that test, and the user's own folder is left alone.
os.environ["TACTILE_MAPS_CACHE"] = "off"

pytest_plugins = [
    "tests.support.bounded_process",
    "tests.support.cpu_report",
    "tests.support.default_cases",
    "tests.support.patient_qtbot",
]
