"""The file of a recording in progress: locked while written; only a complete one replaces an existing file."""

from __future__ import annotations

import os
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import BinaryIO

from tactile_maps.core.errors import RecordingError
from tactile_maps.core.files import IN_USE, lock_file, lock_path, move_into_place, name_next_to, output_path

_FOLDER = "Choose a folder you may write to, with space left"


class RecordingFile:
    """A file being written, locked against other recorders until it is completed, discarded or abandoned.

    A new recording is written in place, so that a killed program loses nothing. An existing file that is to be replaced
    stays until the new one is complete, and if the new one ends with an error; the new one is then ``NAME.new.mcap``
    (or ``NAME.new-2.mcap``, ...) in the same folder. The operating system removes the lock of a killed program.

    Attributes:
        path: Name of the recording.
        written: The file that is being written.
        stream: Its stream.
    """

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        """Create the file.

        Args:
            path: Name of the recording.
            overwrite: Replace an existing file.

        Raises:
            RecordingError: The file exists, another program writes it, or it cannot be written.
        """
        self.path = path
        self.written = output_path(path, error=RecordingError, overwrite=overwrite)
        self._replaced: int | None = None
        try:
            self.stream: BinaryIO = self._create(overwrite)
            if not lock_file(self.stream.fileno()):  # another program has just opened it to replace it
                self.abandon()
                raise RecordingError(IN_USE, file=path, remedy="Choose another name")
        except OSError as error:
            self._release()
            problem = "the recording cannot be written"
            raise RecordingError(problem, file=path, value=error.strerror, remedy=_FOLDER) from error

    def _create(self, overwrite: bool) -> BinaryIO:
        try:
            return self.written.open("xb")
        except FileExistsError:
            output_path(self.path, error=RecordingError, overwrite=overwrite)
        self._replaced = lock_path(self.written, error=RecordingError)
        for number in count(1):
            ending = f".new{'' if number == 1 else f'-{number}'}{self.written.suffix}"
            candidate = name_next_to(self.written, ending)
            try:
                stream = candidate.open("xb")
            except FileExistsError:
                continue
            self.written = candidate
            return stream
        raise AssertionError

    @property
    def replaces(self) -> bool:
        """Whether an existing file is going to be replaced."""
        return self._replaced is not None

    def is_present(self) -> bool:
        """Whether the file being written still has its name."""
        try:
            return os.path.samestat(self.written.stat(), os.fstat(self.stream.fileno()))
        except OSError:
            return False

    def complete(self, *, replace: bool) -> None:
        """Close the file, and replace the existing one if ``replace``.

        Raises:
            OSError: The last bytes cannot be written.
            RecordingError: The existing file can no longer be replaced; the new one stays.
        """
        self.stream.flush()
        if self._replaced is None:
            self.stream.close()
            return
        os.fsync(self.stream.fileno())
        self.stream.close()
        self._release()  # Windows does not replace an open file
        if not replace:
            return
        try:
            move_into_place(self.written, self.path, error=RecordingError)
        except RecordingError as error:
            raise error.at(remedy=f"The complete recording is {self.written}") from error

    def discard(self) -> None:
        """Close and remove the file; an existing one stays."""
        present = not self.stream.closed and self.is_present()
        self.abandon()
        if present:
            self.written.unlink(missing_ok=True)

    def abandon(self) -> None:
        """Close a file that cannot grow; what was written stays."""
        with suppress(OSError):  # reported before: closing tries to write what did not fit
            self.stream.close()
        self._release()

    def _release(self) -> None:
        if self._replaced is not None:
            os.close(self._replaced)
            self._replaced = None
