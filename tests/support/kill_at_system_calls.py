"""Ends a program at each of its system calls in turn, which leaves on the disk what a crash at any instant would leave.

Between two system calls a program changes nothing that outlives it, so ending it before each of them covers every
instant. Linux' ``ptrace`` is used, as in debuggers, because faults injected into Python's file functions would miss the
calls of C libraries.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Callable, Iterator
from functools import cache

_TRACEME = 0
_SYSCALL = 24
_SETOPTIONS = 0x4200
_MARK_SYSCALLS = 1
_END_WITH_TRACER = 0x100000
_AT_SYSCALL = signal.SIGTRAP | 0x80


def can_trace() -> bool:
    """Whether this system lets a process be traced by its parent."""
    if not sys.platform.startswith("linux"):
        return False
    return _run_until(lambda: None, 0) == 0


def killed_at_each_system_call(act: Callable[[], object], *, every: int = 1) -> Iterator[int]:
    """Run ``act`` in forked processes killed before the first, second, ... system call, until one completes.

    Args:
        act: Function to run; with one thread and without child processes.
        every: Stop only at each ``every``-th call.

    Yields:
        After each killed run, the number of system calls it had made. The caller then inspects the disk and restores
        what the next run needs.

    Raises:
        AssertionError: ``act`` raised.
    """
    calls = 0
    while True:
        made = _run_until(act, calls)
        if made < calls:
            return
        yield calls
        calls += every


def _run_until(act: Callable[[], object], calls: int) -> int:
    """Return the number of system calls made: ``calls`` if the process was killed, fewer if it completed."""
    process = os.fork()
    if process == 0:
        code = 1
        try:
            if _ptrace(_TRACEME, 0, 0) == 0:
                os.kill(os.getpid(), signal.SIGSTOP)
                act()
                code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(process, 0)
    if not os.WIFSTOPPED(status):
        return -1  # tracing is not permitted
    _ptrace(_SETOPTIONS, process, _MARK_SYSCALLS | _END_WITH_TRACER)
    made = 0
    inside = False
    deliver = 0
    while True:
        _ptrace(_SYSCALL, process, deliver)
        _, status = os.waitpid(process, 0)
        if os.WIFEXITED(status):
            assert os.WEXITSTATUS(status) == 0, "the act itself failed"
            return made
        assert os.WIFSTOPPED(status), f"ended by signal {os.WTERMSIG(status)}"
        reason = os.WSTOPSIG(status)
        deliver = 0
        if reason != _AT_SYSCALL:
            deliver = reason
        elif inside:
            inside = False
            made = made + 1
        elif made == calls:
            os.kill(process, signal.SIGKILL)
            os.waitpid(process, 0)
            return made
        else:
            inside = True


def _ptrace(request: int, process: int, data: int) -> int:
    return int(_libc_ptrace()(request, process, None, data))


@cache
def _libc_ptrace() -> Callable[..., int]:
    call = ctypes.CDLL(None, use_errno=True).ptrace
    call.argtypes = (ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p)
    call.restype = ctypes.c_long
    return call
