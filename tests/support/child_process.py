"""Child process for calls that might crash or hang in native code; only the affected test fails."""

from __future__ import annotations

import multiprocessing
import traceback
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

_START_SECONDS = 120.0


class Child:
    """Calls functions in another process, which is started at first use and restarted after a crash."""

    def __init__(self) -> None:
        self._process: Any = None
        self._pipe: Any = None

    def call(self, function: Callable[..., Any], *args: Any, seconds: float) -> Any:
        """Return ``function(*args)``; function, arguments and result must be picklable.

        Raises:
            AssertionError: The function raised (the message is its traceback), crashed the process, or exceeded the
                time limit.
        """
        if self._process is None:
            self._start()
        self._pipe.send((function, args))
        try:
            assert self._pipe.poll(seconds), f"{function.__name__}{args} hangs: no result after {seconds} s"
            good, result = self._pipe.recv()
        except (AssertionError, EOFError, ConnectionResetError) as error:
            code = self.close()
            if isinstance(error, AssertionError):
                raise
            raise AssertionError(f"{function.__name__}{args} crashed the process: exit code {code}") from error
        assert good, result
        return result

    def close(self) -> int | None:
        """End the process and return its exit code."""
        if self._process is None:
            return None
        self._pipe.close()
        self._process.join(1.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()
        code = self._process.exitcode
        self._process = None
        return int(code)

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, there = context.Pipe()
        self._process = context.Process(target=_serve, args=(there,), daemon=True)
        self._process.start()
        there.close()
        assert self._pipe.poll(_START_SECONDS), "the child process did not start"
        self._pipe.recv()


def _serve(pipe: Connection) -> None:
    warnings.simplefilter("error")
    pipe.send("ready")
    while True:
        try:
            function, args = pipe.recv()
        except EOFError:
            return
        try:
            result = (True, function(*args))
        except Exception:  # the result of a case may be any exception
            result = (False, traceback.format_exc())
        pipe.send(result)
