"""What stopped a session, as a recording that stops again when it is replayed."""

from __future__ import annotations

from pathlib import Path

from app.errors import RecordingError
from app.recording.recorder import Recorder
from app.session.session import Session


def save_report(session: Session, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write why ``session`` stopped: its scene, all inputs, the last good frame and the error; the file's path.

    Anyone may replay and verify it: the inputs are simulated again, and must end at the same tick with the same words.

    Args:
        session: One whose ``failure`` is set.
        path: The file; it must not exist.
        overwrite: Replace an existing file.

    Raises:
        RecordingError: Nothing stopped the session, or the file cannot be written.
    """
    failure = session.failure
    if failure is None:
        raise RecordingError("there is nothing to report: the session did not stop by itself", file=path)
    with Recorder(path, session.prepared, overwrite=overwrite) as recorder:
        recorder.fail(failure)
    return Path(path)
