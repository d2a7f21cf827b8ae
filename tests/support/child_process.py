"""One child process for what might crash or hang native code: a case that does fails alone, and says so."""

from __future__ import annotations

import multiprocessing
import traceback
import warnings
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

_START_SECONDS = 120.0


class Child:
    """Calls functions in another process, which is started when first needed and again after it died."""

    def __init__(self) -> None:
        self._process: Any = None
        self._pipe: Any = None

    def call(self, function: Callable[..., Any], *args: Any, seconds: float) -> Any:
        """What ``function(*args)`` returns; all three must pickle.

        Raises:
            AssertionError: It raised (the traceback is the message), crashed the process, or took longer.
        """
        if self._process is None:
            self._start()
        self._pipe.send((function, args))
        try:
            assert self._pipe.poll(seconds), f"{function.__name__}{args} hangs: no answer after {seconds} s"
            good, answer = self._pipe.recv()
        except (AssertionError, EOFError, ConnectionResetError) as error:
            code = self.close()
            if isinstance(error, AssertionError):
                raise
            raise AssertionError(f"{function.__name__}{args} crashed the process: exit code {code}") from error
        assert good, answer
        return answer

    def close(self) -> int | None:
        """End the process; returns its exit code."""
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
        self._process = context.Process(target=_answer, args=(there,), daemon=True)
        self._process.start()
        there.close()
        assert self._pipe.poll(_START_SECONDS), "the child process did not start"
        self._pipe.recv()


def _answer(pipe: Connection) -> None:
    warnings.simplefilter("error")
    pipe.send("ready")
    while True:
        try:
            function, args = pipe.recv()
        except EOFError:
            return
        try:
            answer = (True, function(*args))
        except Exception:  # whatever a case raises is its answer
            answer = (False, traceback.format_exc())
        pipe.send(answer)
