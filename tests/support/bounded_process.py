"""Calls functions with untrusted bytes or files in processes with limits on time, memory and open descriptors.

Each process is forked from one that has already imported the program, so a case takes milliseconds. The kernel kills a
process that hangs or allocates too much, also inside native code, and only that case fails.
"""

from __future__ import annotations

import os
import pickle
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

MEMORY = 2 * 2**30  # beyond the imported program, for which rslab alone reserves 1 GB of addresses
CPU_SECONDS = 10
WALL_SECONDS = 120  # wall time for a process that waits without working; long, because the machine may be busy
ROOT = Path(__file__).resolve().parents[2]


class BoundedProcess:
    """Process that has imported the program and from which each call is forked. Call ``close`` at the end."""

    def __init__(self) -> None:
        command = [sys.executable, "-W", "ignore", "-c", "from tests.support.bounded_process import _serve; _serve()"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT)

    def call_all(
        self,
        function: Callable[..., Any],
        cases: Sequence[tuple[Any, ...]],
        *,
        cpu: float = CPU_SECONDS,
        memory: int = MEMORY,
    ) -> list[str]:
        """Call ``function(*case)`` for each case; function and cases must be picklable.

        Returns:
            Outcome of each case: ``"ok"``, ``"refused: ..."`` for a TactileMapsError, ``"traceback: ..."`` for another
            exception, ``"killed by ..."`` for exceeded time or memory, ``"leaked ..."`` for open descriptors.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        pickle.dump((function.__module__, function.__qualname__, list(cases), cpu, memory), self._process.stdin)
        self._process.stdin.flush()
        return pickle.load(self._process.stdout)

    def close(self) -> None:
        """End the process and wait for it."""
        self._process.communicate()


@pytest.fixture(scope="session")
def call_all() -> Iterator[Callable[..., list[str]]]:
    """``BoundedProcess.call_all`` of a process that all tests share: its imports take 2 s."""
    if sys.platform != "linux":
        pytest.skip("the limits need fork and /proc")
    process = BoundedProcess()
    yield process.call_all
    process.close()


def _serve() -> None:
    from importlib import import_module

    results = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # output of native code must not reach the result pipe
    while True:
        try:
            module, name, cases, cpu, memory = pickle.load(sys.stdin.buffer)
        except EOFError:
            os._exit(0)
        function = getattr(import_module(module), name)
        found: list[str] = []
        while len(found) < len(cases):
            found += _run(function, cases[len(found) :], cpu, memory)
        pickle.dump(found, results)
        results.flush()


def _run(function: Callable[..., Any], cases: Sequence[tuple[Any, ...]], cpu: float, memory: int) -> list[str]:
    """Return the outcomes up to the last case, or up to the first that ended its process."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        _work(function, cases, cpu, memory, writing)
    os.close(writing)
    found = []
    rest = b""
    while ready := select.select([reading], [], [], WALL_SECONDS)[0]:
        data = os.read(ready[0], 2**16)
        if not data:
            break
        *lines, rest = (rest + data).split(b"\n")
        found += [line.decode() for line in lines]
    else:
        os.kill(child, signal.SIGKILL)
    os.close(reading)
    _, status = os.waitpid(child, 0)
    if len(found) < len(cases):
        ended = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else f"exit {status}"
        found.append(f"killed by {ended}")
    return found


def _work(function: Callable[..., Any], cases: Sequence[tuple[Any, ...]], cpu: float, memory: int, writing: int) -> Any:
    import resource  # missing on Windows, where this module is imported too

    from tactile_maps.core.errors import TactileMapsError

    memory += _data_size()
    resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    os.dup2(2, 1)
    for case in cases:
        before = set(os.listdir("/proc/self/fd"))
        signal.setitimer(signal.ITIMER_PROF, cpu)  # ends the process, also in native code
        try:
            function(*case)
            text = "ok"
        except TactileMapsError as error:
            text = f"refused: {error}"
        except BaseException as error:
            places = []
            trace = error.__traceback__
            while trace:
                places.append(f"{Path(trace.tb_frame.f_code.co_filename).name}:{trace.tb_lineno}")
                trace = trace.tb_next
            text = f"traceback: {type(error).__name__}: {error} at {' '.join(places[-6:])}"
            del trace
        signal.setitimer(signal.ITIMER_PROF, 0)
        leaked = len(set(os.listdir("/proc/self/fd")) - before)
        if leaked > 0:
            text = f"leaked {leaked} descriptors; {text}"
        os.write(writing, (" ".join(text.split())[:2000] + "\n").encode(errors="replace"))
    os._exit(0)


def _data_size() -> int:
    status = Path("/proc/self/status").read_text()
    return next(int(line.split()[1]) * 1024 for line in status.splitlines() if line.startswith("VmData:"))
