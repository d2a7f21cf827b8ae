"""End a program at each of its system calls in turn: what it leaves on the disk is what a crash at any instant leaves.

Between two system calls a program changes nothing that outlives it, so that ending it before each of them tries every
instant there is. It is done as debuggers do (Linux' ``ptrace``), since a fault put into Python's own file functions
would miss the calls of C libraries.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from collections.abc import Callable, Iterator

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
    """Run ``act`` in a forked process that is killed before its first system call, its second, ... until one ends.

    Args:
        act: What to do; of one thread, and without its own children.
        every: Only each ``every``-th call.

    Yields:
        After each run that was killed, the number of system calls it had made. Look at the disk then, and put back what
        the next run is to find.

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
    """How many system calls it made: at ``calls`` it is killed before the next, with fewer it ended by itself."""
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
        return -1  # it may not be traced
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
    call = ctypes.CDLL(None, use_errno=True).ptrace
    call.argtypes = (ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p)
    call.restype = ctypes.c_long
    return int(call(request, process, None, data))
