"""Warnings of MuJoCo's C code, collected instead of printed, and the findings that they become.

MuJoCo prints such a warning and appends it to the file MUJOCO_LOG.TXT in the working folder. Its parser and its steps
warn this way; its compiler warns through Python's ``warnings`` instead.
"""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import mujoco

from tactile_maps.core.errors import Finding, places_finding

_lock = threading.Lock()
_texts: dict[int, list[list[str]]] = {}
"""Lists that collect, innermost last, by the identifier of their thread."""
_previous: Callable[[str], object] | None = None
"""Handler that is installed while no thread collects."""


@contextmanager
def collect_warnings() -> Iterator[list[str]]:
    """Return the list to which warnings of this thread are added until the context ends.

    MuJoCo has one handler for all threads. It is replaced only while a thread collects, and warnings of the other
    threads, for example of a simulation, are passed on to the previous handler or written to MuJoCo's log.
    """
    global _previous
    thread = threading.get_ident()
    texts = list[str]()
    with _lock:
        if not _texts:
            _previous = mujoco.get_mju_user_warning()
            mujoco.set_mju_user_warning(_receive)
        _texts.setdefault(thread, []).append(texts)
    try:
        yield texts
    finally:
        with _lock:
            _texts[thread].pop()
            if not _texts[thread]:
                del _texts[thread]
            if not _texts:
                mujoco.set_mju_user_warning(_previous)


def _receive(text: str) -> None:
    """Handle a warning in the thread that causes it; an exception here would end the process."""
    collecting = _texts.get(threading.get_ident())
    if collecting:
        collecting[-1].append(text)
    elif _previous is not None:
        _previous(text)
    else:
        mujoco.mju_writeLog("WARNING", text)


_EQUAL_LIMITS = re.compile(r"joint '(.*)' has equal lower and upper limits")
_LIMITS_ACTION = (
    "ignored: the lower limit is not less than the upper limit, so the joint moves without limits; "
    "state two different limits, or make the joint fixed"
)


def limit_findings(spec: mujoco.MjSpec, texts: Sequence[str], *, urdf: bool) -> list[Finding]:
    """Return a finding for joints whose stated limits MuJoCo ignores because the lower one is not less than the upper.

    MuJoCo warns only of equal limits in URDF files. Without that warning, a range of 0 to 0 means that none is stated.

    Args:
        spec: The spec as parsed, with the limits in the file's unit.
        texts: Warnings of parsing it.
        urdf: True for a spec from URDF, whose parser marks such joints as unlimited. In MJCF only the file can do so,
            and the limits are then unused on purpose.
    """
    used = [joint for joint in spec.joints if urdf or joint.limited != mujoco.mjtLimited.mjLIMITED_FALSE]
    equal = {found[1] for text in texts if (found := _EQUAL_LIMITS.match(text))}
    ignored = [j for j in used if j.range[0] >= j.range[1] and (any(j.range) or j.name in equal)]
    places = [f"{joint.name or 'unnamed'} ({joint.range[0]:g} to {joint.range[1]:g})" for joint in ignored]
    places[:1] = [f"joint {place}" for place in places[:1]]
    detail = next((f". MuJoCo: {text}" for text in texts if _EQUAL_LIMITS.match(text)), "")
    return places_finding("joint-limits", places, _LIMITS_ACTION + detail)


def warning_findings(texts: Sequence[str], *, source: str) -> list[Finding]:
    """Return one finding for each distinct warning, except those that ``limit_findings`` reports.

    Args:
        texts: The warnings.
        source: Path or name of the robot, the place of warnings that name no element.
    """
    findings = list[Finding]()
    for text in dict.fromkeys(texts):
        if not _EQUAL_LIMITS.match(text):
            named = re.search(r"(\w+) '([^']+)'", text)
            where = f"{named[1]} {named[2]}" if named else source
            message = " ".join(text.split())
            action = f"MuJoCo warns of this; check it in the file. MuJoCo: {message}"
            findings.append(Finding("mujoco-warning", where, action, texts.count(text)))
    return findings
