"""What the times were measured on: without it no time means anything."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version
from pathlib import Path

_LIBRARIES = ("tactile-maps", "numpy", "scipy", "libigl")
_LINUX_NAMES = Path("/proc/cpuinfo")


def describe() -> dict[str, str]:
    """Processor, cores, system and versions, as text."""
    return {
        "processor": _processor(),
        "cores": str(os.cpu_count()),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "Python": platform.python_version(),
        **{name: version(name) for name in _LIBRARIES},
    }


def _processor() -> str:
    """The processor's name; on Linux ``platform`` does not know it."""
    if _LINUX_NAMES.is_file():
        for line in _LINUX_NAMES.read_text(encoding="utf8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
