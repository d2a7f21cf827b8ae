"""Checks the files and folders that a command will write, before it does any work."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from app.core.errors import ExportError, UsageError
from app.core.files import check_output, check_output_folder, new_outputs


@contextmanager
def outputs_checked(arguments: argparse.Namespace) -> Iterator[None]:
    """Refuse outputs that cannot be written; in the block, an existing file is replaced only with ``--overwrite``.

    Raises:
        ExportError: An output exists, is a special file, or cannot be written.
        UsageError: Two outputs are the same file.
    """
    new: list[Path] = []
    seen: list[Path] = []
    for name, folder_option in getattr(arguments, "outputs", ()):
        stated = getattr(arguments, name)
        if stated is None:
            continue
        path = Path(stated)
        if path.absolute() in seen:
            raise UsageError("two outputs have the same name", value=path, remedy="Choose two names")
        seen.append(path.absolute())
        if folder_option and getattr(arguments, folder_option):
            check_output_folder(path, error=ExportError)
            continue
        check_output(path, error=ExportError, overwrite=arguments.overwrite)
        if not arguments.overwrite:
            new.append(path)
    with new_outputs(new):
        yield


def check_outputs_in(folder: Path, names: Iterable[str], *, overwrite: bool) -> None:
    """Refuse to write these files in ``folder``, which need not exist, where one of them cannot be written.

    Raises:
        ExportError: A file exists and must not be replaced, is a special file, or cannot be written.
    """
    check_output_folder(folder, error=ExportError)
    if folder.is_dir():
        for name in names:
            check_output(folder / name, error=ExportError, overwrite=overwrite)
