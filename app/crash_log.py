"""Where the details of an unexpected problem go, so that a person is told a sentence and a developer gets the rest."""

from __future__ import annotations

import traceback
from datetime import datetime
from pathlib import Path

from platformdirs import user_log_path


def write_crash_log(error: BaseException) -> Path:
    """Write the traceback of ``error`` to a new file in the user's log folder; the file is returned."""
    folder = user_log_path("tactile-maps", appauthor=False)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"crash {datetime.now():%Y-%m-%d %H.%M.%S.%f}.txt"
    path.write_text("".join(traceback.format_exception(error)), encoding="utf8")
    return path


def explain(error: BaseException) -> str:
    """One sentence for a person about a problem nobody foresaw, naming the file with the details."""
    try:
        where = f"The details are in {write_crash_log(error)}"
    except OSError as failure:
        where = f"The details could not be written ({failure.strerror})"
    return f"an unexpected problem: {type(error).__name__}: {error}. {where}"
