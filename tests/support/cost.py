"""Cost of a computation, counted instead of timed: the result does not depend on the machine or on its load."""

from __future__ import annotations

import sys
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from types import FrameType
from typing import Any


@dataclass(frozen=True)
class Cost:
    """Cost of one call.

    Attributes:
        steps: Number of bytecode instructions of Python. A loop in Python over the items of an array adds some for each
            item; an operation on the whole array adds none.
        memory: Largest memory allocated at one time [bytes], arrays of NumPy included. Comparing all items with each
            other in one operation on arrays needs memory for each pair.
    """

    steps: int
    memory: int


def cost_of(compute: Callable[[], Any], *, function: str | None = None) -> Cost:
    """Return the cost of ``compute()``. It runs twice: once to count steps, once to measure memory.

    Args:
        compute: Computation without an effect that would change the second run.
        function: Count only the steps of functions with this name; None for all functions.
    """
    return Cost(_steps(compute, function), _memory(compute))


def _steps(compute: Callable[[], Any], function: str | None) -> int:
    count = 0

    def trace(frame: FrameType, event: str, _: Any) -> Callable[..., Any] | None:
        nonlocal count
        if function not in (None, frame.f_code.co_name):
            return None
        frame.f_trace_opcodes = True
        frame.f_trace_lines = False
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        compute()
    finally:
        sys.settrace(before)
    return count


def _memory(compute: Callable[[], Any]) -> int:
    running = tracemalloc.is_tracing()
    if not running:
        tracemalloc.start()
    try:
        tracemalloc.reset_peak()
        begun, _ = tracemalloc.get_traced_memory()
        compute()
        return tracemalloc.get_traced_memory()[1] - begun
    finally:
        if not running:
            tracemalloc.stop()
