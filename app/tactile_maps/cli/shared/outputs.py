"""Checks the files and folders that a command will write, before it does any work."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from tactile_maps.core.errors import ExportError, UsageError
from tactile_maps.core.file_kinds import FileKind
from tactile_maps.core.files import check_ending, check_output, check_output_folder, new_outputs


@contextmanager
def outputs_checked(arguments: argparse.Namespace) -> Iterator[None]:
    """Reject outputs that cannot be written; in the block, an existing file is replaced only with ``--overwrite``.

    Raises:
        ExportError: An output exists, is a special file or a file that the command reads, cannot be written, or is a
            name with the extension of another format.
        UsageError: Two outputs are the same file.
    """
    outputs = getattr(arguments, "outputs", ())
    if not outputs:
        yield
        return
    with new_outputs(()):
        new = _checked_outputs(arguments, outputs)
    with new_outputs(new):
        yield


def _checked_outputs(arguments: argparse.Namespace, outputs: Iterable[tuple[str, str, str]]) -> list[Path]:
    """Return the files that must be new."""
    new: list[Path] = []
    read = list(_files_read(arguments))
    seen: list[Path] = []
    for name, folder_option, suffix in outputs:
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
        if any(_is_same(path, other) for other in read):
            raise ExportError("a file that is read cannot be the output", file=path, remedy="Choose another name")
        if suffix:
            check_ending(path, suffix, error=ExportError, required=suffix in FileKind.RECORDING.suffixes)
        if not arguments.overwrite:
            new.append(path)
    return new


def _files_read(arguments: argparse.Namespace) -> Iterator[str]:
    """Return all other values on the command line that may name a file."""
    outputs = {name for name, *_ in getattr(arguments, "outputs", ())}
    for name, value in vars(arguments).items():
        if name not in outputs:
            words = value if isinstance(value, list | tuple) else [value]
            yield from (os.fspath(word) for word in words if isinstance(word, str | Path))


def _is_same(path: Path, other: str) -> bool:
    try:
        return path.samefile(other)
    except (OSError, ValueError):  # one of them does not exist, or is not a file name
        return False


def check_outputs_in(folder: Path, names: Iterable[str], *, overwrite: bool) -> None:
    """Check that all of these files can be written in ``folder``, which need not exist.

    Raises:
        ExportError: A file exists and must not be replaced, is a special file, or cannot be written.
    """
    check_output_folder(folder, error=ExportError)
    if folder.is_dir():
        for name in names:
            check_output(folder / name, error=ExportError, overwrite=overwrite)
