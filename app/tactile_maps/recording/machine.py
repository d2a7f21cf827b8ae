"""Processor and BLAS kernel of this machine, on which the last digits of floating-point results depend.

OpenBLAS chooses its kernels for the processor when it is loaded, and kernels add in different orders.
"""

from __future__ import annotations

import ctypes
import platform
import sys
from functools import cache
from pathlib import Path

import numpy as np
from numpy.linalg import _umath_linalg

_KERNEL_NAMES = ("scipy_openblas_get_corename64_", "openblas_get_corename64_", "openblas_get_corename")
"""Functions of OpenBLAS builds that return the name of the kernels in use."""


@cache
def machine_facts() -> dict[str, str]:
    """Return the processor (``cpu``) and NumPy's BLAS with its kernel (``blas``), as far as they are known."""
    blas = np.show_config(mode="dicts")["Build Dependencies"]["blas"]
    kernel = _blas_kernel()
    name = f"{blas.get('name', 'unknown')} {blas.get('version', '')}".strip()
    return {"cpu": _cpu_model(), "blas": f"{name}, kernel {kernel}" if kernel else name}


def _cpu_model() -> str:
    if sys.platform == "linux":
        try:
            lines = Path("/proc/cpuinfo").read_text(encoding="utf8", errors="replace").splitlines()
        except OSError:
            lines = []
        for line in lines:
            key, _, value = line.partition(":")
            if key.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()


def _blas_kernel() -> str:
    """Return the name of the kernels that OpenBLAS uses on this processor; empty if NumPy uses another BLAS."""
    try:
        library = ctypes.CDLL(_umath_linalg.__file__)  # also finds symbols of the libraries that it depends on
    except OSError:
        return ""
    for name in _KERNEL_NAMES:
        function = getattr(library, name, None)
        if function is not None:
            function.restype = ctypes.c_char_p
            return str(function().decode(errors="replace"))
    return ""
