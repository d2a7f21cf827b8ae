"""Bounded reads, atomic writes, and named arrays as bytes (the npz format).

Bytes: ``read_bounded_file`` rejects a file that is too large before reading it; ``write_atomically`` writes a new file
next to the target and renames it, so that a failure leaves the old file unchanged. Every error names the file.

Outputs: ``check_output`` states which paths may be written: new and regular files. Every function that writes uses it.

Arrays: skins, maps and whatever else is mostly arrays are kept as npz with a JSON header; any tool that reads npz can
open them. They are not trusted: pickles, decompression bombs and wrong sizes are rejected.
"""

from __future__ import annotations

import codecs
import errno
import io
import json
import math
import os
import re
import secrets
import shutil
import stat
import sys
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from platformdirs import user_cache_path

from tactile_maps.core.codec import parse_json
from tactile_maps.core.errors import TactileMapsError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

MAX_FILE_BYTES = 64 * 2**20
"""Maximum size of a file of another program, unless its format has another bound."""


_KINDS: Mapping[int, str] = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


_READ: ContextVar[list[Path] | None] = ContextVar("files read", default=None)


FOLDER_VARIABLE = "TACTILE_MAPS_CACHE"
"""Environment variable with the folder of cached results, or ``off``."""


def cache_folder() -> Path | None:
    """Return the folder of cached results; None if ``$TACTILE_MAPS_CACHE`` is ``off``."""
    stated = os.environ.get(FOLDER_VARIABLE, "")
    if stated == "off":
        return None
    return Path(stated) if stated else user_cache_path("tactile-maps", appauthor=False) / "prepared"


@contextmanager
def files_read() -> Iterator[list[Path]]:
    """Return a list to which the absolute path of every file opened for reading in the block is added."""
    read: list[Path] = []
    token = _READ.set(read)
    try:
        yield read
    finally:
        _READ.reset(token)


@contextmanager
def open_regular_file(path: Path, *, error: type[TactileMapsError]) -> Iterator[BinaryIO]:
    """Open a file for reading. Pipes and devices, on which a read could block forever, are rejected at once.

    Raises:
        TactileMapsError: The file cannot be opened or read, or is not a regular file; raised as ``error``.
    """
    try:
        # O_NONBLOCK avoids waiting for the other end of a pipe; it does not affect regular files.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        try:
            kind = stat.S_IFMT(os.fstat(descriptor).st_mode)
            if kind == stat.S_IFDIR:
                raise error("the file cannot be read", file=path, value="a folder", remedy="Name a file in it")
            if kind != stat.S_IFREG:
                value = _KINDS.get(kind, "something else")
                raise error("this is not a file", file=path, value=value, remedy="Name a file; copy a stream into one")
            if (read := _READ.get()) is not None:
                read.append(path.absolute())
            with open(descriptor, "rb", closefd=False) as stream:
                yield stream
        finally:
            os.close(descriptor)  # a folder's descriptor is left open by ``open``, which refuses it
    except (OSError, ValueError) as cause:
        reason = getattr(cause, "strerror", None) or cause
        raise error("the file cannot be read", file=path, value=reason, remedy="Check the path") from cause


def _size_text(size: int) -> str:
    """Return a number of bytes as text in the largest suitable unit."""
    for unit, factor in (("MiB", 2**20), ("KiB", 2**10)):
        if size >= factor:
            return f"{size / factor:.3g} {unit}"
    return f"{size} bytes"


def read_bounded_file(path: Path, *, error: type[TactileMapsError], most: int = MAX_FILE_BYTES) -> bytes:
    """Return the content of a file.

    Raises:
        TactileMapsError: The file is unreadable, not a regular file, or above ``most`` bytes; raised as ``error``.
    """
    with open_regular_file(path, error=error) as stream:
        size = os.fstat(stream.fileno()).st_size
        data = b"" if size > most else stream.read(size + 1)  # one more: some files state no size, or grow
        while size < len(data) <= most and (more := stream.read(2**20)):
            data += more
        size = max(size, len(data))
        if size > most:
            remedy = f"The maximum is {_size_text(most)}"
            raise error("the file is too large", file=path, value=f"{size} bytes", remedy=remedy)
        return data


def read_bounded_text(path: Path, *, error: type[TactileMapsError], most: int = MAX_FILE_BYTES) -> str:
    """Return the content of a file as text; bytes that are not in its encoding become the replacement character.

    Raises:
        TactileMapsError: Same as for ``read_bounded_file``.
    """
    data = read_bounded_file(path, error=error, most=most)
    return data.decode(text_encoding(data), errors="replace")


def text_encoding(start: bytes) -> str:
    """Return the encoding of text that begins with these bytes: UTF-16 if they mark it, as in text from Excel."""
    return "utf-16" if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) else "utf-8-sig"


_NEW: ContextVar[frozenset[Path] | None] = ContextVar("files that must be new, None outside commands", default=None)


@contextmanager
def new_outputs(paths: Iterable[Path]) -> Iterator[None]:
    """Reject replacing any of these files within the block, even where the writing function allows it by default.

    A file that another program creates in the meantime is therefore not lost. The block belongs to a command: errors
    about existing files name its option ``--overwrite`` instead of the argument ``overwrite``.
    """
    token = _NEW.set((_NEW.get() or frozenset()) | {path.absolute() for path in paths})
    try:
        yield
    finally:
        _NEW.reset(token)


IN_USE = "another program is writing this file"


def _in_use(path: Path, error: type[TactileMapsError]) -> TactileMapsError:
    return error(IN_USE, file=path, remedy="Wait until it has finished, or choose another name")


def check_output(path: Path, *, error: type[TactileMapsError], overwrite: bool = True) -> Path:
    """Check that ``path`` can become a file; return the path to write to, which for a symbolic link is its target.

    Only a new or a regular file is an output. Replacing a device, a pipe or a socket would destroy it.

    Raises:
        TactileMapsError: A folder, a device, a pipe or a socket has this name, the folder does not exist, or the file
            exists and is read-only, must not be replaced, or is locked by another writer, such as a recorder; raised
            as ``error``.
    """
    target = output_path(path, error=error, overwrite=overwrite)
    try:
        with target.open("r+b") as stream:
            in_use = is_locked(stream.fileno())
    except FileNotFoundError:
        return target
    except OSError as cause:
        raise _not_writable(path, cause, error) from cause
    if in_use:
        raise _in_use(path, error)
    return target


def check_ending(path: Path, *endings: str, error: type[TactileMapsError], required: bool = False) -> None:
    """Check that the name of an output has one of these endings, or no extension unless one is required.

    Args:
        path: The file.
        endings: Extensions of its format in lower case, the usual one first.
        error: Type of the error.
        required: Whether a file without an extension could not be opened.

    Raises:
        TactileMapsError: It has another extension; raised as ``error``.
    """
    if path.name.lower().endswith(endings) if path.suffix else not required:
        return
    raise error(
        f"the name of this file must end in {' or '.join(endings)}",
        file=path,
        value=path.suffix or "no file extension",
        remedy=f"Choose the name {path.stem}{endings[0]}",
    )


def output_path(path: Path, *, error: type[TactileMapsError], overwrite: bool = True) -> Path:
    """Check a path like ``check_output``, for a writer that locks an existing file itself."""
    try:
        target = Path(os.path.realpath(path)) if path.is_symlink() else path
        found = _status(target)
    except (OSError, ValueError) as cause:
        raise _not_writable(path, cause, error) from cause
    if found is None:
        if not target.parent.is_dir():
            problem = "the file cannot be written"
            value = f"the folder {target.parent} does not exist"
            raise error(problem, file=path, value=value, remedy="Create the folder, or choose a folder that exists")
        return target
    kind = stat.S_IFMT(found.st_mode)
    if kind == stat.S_IFDIR:
        raise error("there is a folder of this name", file=path, remedy="Choose another name, or remove it first")
    if kind != stat.S_IFREG:
        value = _KINDS.get(kind, "a special file")
        raise error("the output is not a regular file", file=path, value=value, remedy="Choose the name of a new file")
    new = _NEW.get()
    if not overwrite or path.absolute() in (new or ()):
        remedy = f"Choose another name, or overwrite it ({'overwrite=True' if new is None else '--overwrite'})"
        raise error("the file already exists", file=path, remedy=remedy)
    if not found.st_mode & 0o222 or not os.access(target, os.W_OK):
        raise error("the file is read-only", file=path, remedy="Choose another name, or make the file writable")
    return target


def _status(path: Path) -> os.stat_result | None:
    """Return the status of the file; None where it does not exist."""
    try:
        return path.stat()
    except FileNotFoundError:
        return None


def _not_writable(
    path: Path, cause: Exception, error: type[TactileMapsError], problem: str = "the file cannot be written"
) -> TactileMapsError:
    reason = getattr(cause, "strerror", None) or cause
    return error(problem, file=path, value=reason, remedy="Choose a folder you may write to, with space left")


def check_output_folder(folder: Path, *, error: type[TactileMapsError]) -> None:
    """Check that ``folder`` is a folder, or that nothing has this name.

    Raises:
        TactileMapsError: A file or a special file has this name; raised as ``error``.
    """
    try:
        found = _status(folder)
    except (OSError, ValueError) as cause:
        raise _not_writable(folder, cause, error, "the folder cannot be created") from cause
    if found is not None and not stat.S_ISDIR(found.st_mode):
        value = f"{_KINDS.get(stat.S_IFMT(found.st_mode), 'a file')} of this name"
        raise error("the folder cannot be created", file=folder, value=value, remedy="Choose another name")


def make_output_folder(folder: Path, *, error: type[TactileMapsError]) -> Path:
    """Create ``folder``, and the folders above it, where they do not exist; return it.

    Raises:
        TactileMapsError: The folder cannot be created; raised as ``error``.
    """
    check_output_folder(folder, error=error)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as cause:
        raise _not_writable(folder, cause, error, "the folder cannot be created") from cause
    return folder


def write_atomically(path: Path, data: bytes, *, error: type[TactileMapsError], overwrite: bool = True) -> None:
    """Write ``data`` to the file at ``path`` completely or not at all; errors as ``open_atomically``."""
    with open_atomically(path, error=error, overwrite=overwrite) as stream:
        stream.write(data)


@contextmanager
def open_atomically(path: Path, *, error: type[TactileMapsError], overwrite: bool = True) -> Iterator[BinaryIO]:
    """Yield a stream whose content becomes the file at ``path`` when the block ends; on failure nothing changes.

    The bytes are written to a new file in the same folder with a unique name, so that several writers never share one,
    and are on the disk before the file is renamed to the target. A symbolic link stays and its target is replaced; a
    replaced file keeps its permissions and owner. Other hard links keep the old content. If the program is killed
    meanwhile, the new file remains: ``.tactile-maps-....part``.

    Raises:
        TactileMapsError: The file cannot be written, or ``check_output`` fails; raised as ``error``.
    """
    with _replacing(path, overwrite, error) as part, part.open("xb") as stream:
        yield stream
        stream.flush()
        os.fsync(stream.fileno())


@contextmanager
def make_atomically(path: Path, *, error: type[TactileMapsError], overwrite: bool = False) -> Iterator[Path]:
    """Yield an unused path in the folder of ``path``, for a library that creates its file or folder itself.

    When the block ends, the file or folder is renamed to ``path``, as in ``open_atomically``; when the block fails, it
    is deleted. If the program is killed meanwhile, ``.tactile-maps-....part`` remains.

    Raises:
        TactileMapsError: The path cannot be written or is a folder, or ``check_output`` fails; raised as ``error``.
    """
    with _replacing(path, overwrite, error) as part:
        yield part
        if part.is_file():
            with part.open("rb") as stream:
                os.fsync(stream.fileno())


@contextmanager
def _replacing(path: Path, overwrite: bool, error: type[TactileMapsError]) -> Iterator[Path]:
    """A path in the folder of ``path``; what is made there takes its name, or is removed where the block fails."""
    part = check_output(path, error=error, overwrite=overwrite).with_name(f".tactile-maps-{secrets.token_hex(8)}.part")
    try:
        try:
            yield part
            move_into_place(part, path, error=error, overwrite=overwrite)  # checks again: it may exist by now
        except BaseException:
            if part.is_dir():
                shutil.rmtree(part, ignore_errors=True)
            else:
                part.unlink(missing_ok=True)
            raise
    except (OSError, ValueError) as cause:
        raise _not_writable(path, cause, error) from cause


def move_into_place(part: Path, path: Path, *, error: type[TactileMapsError], overwrite: bool = True) -> None:
    """Give a finished file or folder on the same disk the name ``path``, as the end of ``open_atomically``.

    Raises:
        TactileMapsError: The file cannot be moved, or ``check_output`` fails; raised as ``error``. ``part`` stays.
    """
    target = check_output(path, error=error, overwrite=overwrite)
    try:
        found = _status(target)
        if found is not None:
            if sys.platform != "win32":
                with suppress(OSError):  # only root can give a file to another user
                    os.chown(part, found.st_uid, found.st_gid)
            part.chmod(found.st_mode & 0o777)
        part.replace(target)
    except OSError as cause:
        raise _not_writable(path, cause, error) from cause


class FolderClaim:
    """Exclusive claim on a folder until ``release`` or the end of the process. See ``claim_folder``."""

    def __init__(self, folder: Path, descriptor: int) -> None:
        self.folder = folder
        self._descriptor = descriptor

    def release(self) -> None:
        """Release the folder for others. May be called once."""
        os.close(self._descriptor)


def claim_folder(parent: Path, *, without: str) -> FolderClaim:
    """Claim the first of the folders 1, 2, ... in ``parent`` that is free and does not contain a file ``without``.

    Two windows on one robot would otherwise overwrite each other's copies. The lock is the operating system's, so that
    a process that was killed leaves its folder, and the files in it, to the next one.

    Raises:
        OSError: The folders cannot be created.
    """
    parent.mkdir(parents=True, exist_ok=True)
    for folder in (parent / str(number) for number in count(1)):
        folder.mkdir(exist_ok=True)
        if not (folder / without).exists() and (claim := _claim(folder)) is not None:
            return claim
    raise AssertionError


def claim_folders_with(parent: Path, name: str) -> list[FolderClaim]:
    """Claim the free folders in ``parent`` that contain a file of this name.

    Raises:
        OSError: A folder cannot be read.
    """
    if not parent.is_dir():
        return []
    found = [path for path in parent.iterdir() if path.name.isdecimal() and (path / name).exists()]
    claims = [_claim(path) for path in sorted(found, key=lambda path: int(path.name))]
    return [claim for claim in claims if claim is not None]


def _claim(folder: Path) -> FolderClaim | None:
    descriptor = os.open(folder / ".lock", os.O_RDWR | os.O_CREAT)
    if lock_file(descriptor):
        return FolderClaim(folder, descriptor)
    os.close(descriptor)
    return None


_TRIAL_BYTES = 16_384


def lock_file(descriptor: int) -> bool:
    """Lock a file that is open for writing; return whether no other descriptor has the lock.

    The lock ends with the descriptor, also when the process is killed. On Linux it holds on NFS as well. A file system
    that has no locks gives no protection: every writer gets the lock.
    """
    try:
        if sys.platform == "win32":
            before = os.lseek(descriptor, 0, os.SEEK_CUR)
            os.lseek(descriptor, _LOCKED_BYTE, os.SEEK_SET)
            try:
                msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
            finally:
                os.lseek(descriptor, before, os.SEEK_SET)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EAGAIN, errno.EACCES, errno.EDEADLK)
    return True


def is_locked(descriptor: int) -> bool:
    """Return whether another descriptor has the lock of ``lock_file``. The file may be open for reading only."""
    if sys.platform == "win32":
        free = lock_file(descriptor)
        if free:
            os.lseek(descriptor, _LOCKED_BYTE, os.SEEK_SET)
            with suppress(OSError):
                msvcrt.locking(descriptor, msvcrt.LK_UNLCK, 1)
            os.lseek(descriptor, 0, os.SEEK_SET)
        return not free
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
        fcntl.flock(descriptor, fcntl.LOCK_UN)
    except OSError as error:
        return error.errno in (errno.EAGAIN, errno.EACCES, errno.EDEADLK)
    return False


_LOCKED_BYTE = 2**31 - 2
"""Windows forbids others to read a locked byte, so that one far behind the content is locked."""


def lock_path(path: Path, *, error: type[TactileMapsError]) -> int:
    """Lock an existing file; return the descriptor that holds the lock.

    Raises:
        TactileMapsError: Another writer has the lock, or the file was replaced at this instant; raised as ``error``.
        OSError: The file cannot be opened.
    """
    descriptor = os.open(path, os.O_RDWR | getattr(os, "O_BINARY", 0))
    try:
        if lock_file(descriptor) and os.path.samestat(os.fstat(descriptor), path.stat()):
            return descriptor
        raise _in_use(path, error)
    except BaseException:
        os.close(descriptor)
        raise


def name_next_to(path: Path, ending: str) -> Path:
    """Return the path in the same folder with another ending; a long name is cut, as names have at most 255 bytes."""
    stem = os.fsencode(path.stem)[: 255 - len(os.fsencode(ending))]
    return path.with_name(os.fsdecode(stem) + ending)


def try_writing(folder: Path) -> None:
    """Write a small file into ``folder``, which is created if necessary, and delete it again.

    Raises:
        OSError: It cannot be written: the disk is full or read-only, or the folder cannot be created.
    """
    folder.mkdir(parents=True, exist_ok=True)
    trial = folder / f".tactile-maps-{secrets.token_hex(8)}.part"
    try:
        trial.write_bytes(bytes(_TRIAL_BYTES))
    finally:
        trial.unlink(missing_ok=True)


def write_lines(path: Path, lines: Iterable[str], *, error: type[TactileMapsError]) -> None:
    """Write a text file completely or not at all; errors as ``write_atomically``."""
    write_atomically(path, ("\n".join(lines) + "\n").encode(errors="replace"), error=error)


MAX_UNPACKED_BYTES = 3 * 2**27
"""Maximum unpacked size of all arrays of one file."""
MAX_MEMBERS = 10_000
MAX_HEADER_BYTES = 2**24
ZIP_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, RuntimeError)
"""Errors raised by damaged archives; an unknown packing method raises NotImplementedError, a RuntimeError."""
_HEADER = "header"
_LENGTH_BYTES = {(1, 0): 2, (2, 0): 4}
"""Bytes of the length of an npy header, by version of the format."""
_MAX_NPY_HEADER = 10_000
_SET_NUMBER = re.compile(r"^\d+_")
_NPY_HEADER = re.compile(
    r"""\{\s*['"]descr['"]:\s*(?P<descr>['"][^'"]*['"]|\[.*\]),\s*['"]fortran_order['"]:\s*(?P<fortran>True|False),"""
    r"""\s*['"]shape['"]:\s*\((?P<shape>(\s*\d{1,18}\s*,)*\s*(\d{1,18})?\s*)\)\s*,?\s*\}\s*"""
)
_NUMBER_TYPE = re.compile(r"[<>|=]?(f[248]|[iu][1248]|b1)")


def pack_arrays(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return an npz with ``arrays`` and a JSON ``header``; equal input gives equal bytes."""
    text = json.dumps(header, sort_keys=True, ensure_ascii=False).encode()
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{_HEADER: np.frombuffer(text, np.uint8)}, **arrays)
    return buffer.getvalue()


def unpack_arrays(
    data: bytes,
    *,
    file: str | Path | None = None,
    error: type[TactileMapsError],
    max_bytes: int = MAX_UNPACKED_BYTES,
    max_rows: Mapping[str, int] = MappingProxyType({}),
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the header and the arrays of a file that ``pack_arrays`` made.

    Args:
        data: The file's bytes, from anyone.
        file: Its name, for errors.
        error: The kind of error to raise.
        max_bytes: More than this unpacked is refused before unpacking.
        max_rows: Largest first lengths of arrays by their names without the number of their set (``2_positions`` is
            ``positions``). An array that states more is refused before it is unpacked.

    Raises:
        TactileMapsError: The bytes are not an npz, are damaged, too large or pickled, or have no header; raised as
            ``error``.
    """
    arrays = unpack_bare_arrays(data, file=file, error=error, max_bytes=max_bytes, max_rows=max_rows)
    if _HEADER not in arrays:
        raise error("the file has no header", file=file, remedy="Open a file that this program saved")
    try:
        header = parse_json(arrays.pop(_HEADER).astype(np.uint8).tobytes(), constants=True)
    except ValueError as cause:
        raise error("the file is damaged or of another kind", file=file, value=cause) from cause
    if not isinstance(header, dict):
        raise error("the file's header is not an object", file=file, value=header)
    return header, arrays


def array_format(stream: BinaryIO) -> str | None:
    """Return the ``format`` in the header of a file that ``pack_arrays`` made; None for other data, damaged or not."""
    try:
        with zipfile.ZipFile(stream) as archive:
            member = archive.getinfo(f"{_HEADER}.npy")
            if member.file_size > MAX_HEADER_BYTES:
                return None
            header = parse_json(
                _read_member(archive, member, None, TactileMapsError).astype(np.uint8).tobytes(), constants=True
            )
    except (TactileMapsError, KeyError, *ZIP_DAMAGE):
        return None
    name = header.get("format") if isinstance(header, dict) else None
    return name if isinstance(name, str) else None


def unpack_bare_arrays(
    data: bytes,
    *,
    file: str | Path | None = None,
    error: type[TactileMapsError],
    max_bytes: int = MAX_UNPACKED_BYTES,
    max_rows: Mapping[str, int] = MappingProxyType({}),
) -> dict[str, NDArray[Any]]:
    """Return the arrays of an npz of any program, by name; arguments and errors as ``unpack_arrays``."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            _check_sizes(members, file, error, max_bytes)
            return {
                member.filename.removesuffix(".npy"): _read_member(archive, member, file, error, max_rows)
                for member in members
            }
    except ZIP_DAMAGE as cause:
        raise error("the file is damaged or of another kind", file=file, value=cause) from cause


def _check_sizes(
    members: list[zipfile.ZipInfo], file: str | Path | None, error: type[TactileMapsError], max_bytes: int
) -> None:
    total = sum(member.file_size for member in members)
    if len(members) > MAX_MEMBERS or total > max_bytes:
        raise error(
            "the file would unpack to an implausible size",
            file=file,
            value=f"{len(members)} arrays, {total} bytes",
            remedy=f"The maximum is {MAX_MEMBERS} arrays and {max_bytes} bytes",
        )


def _read_member(
    archive: zipfile.ZipFile,
    member: zipfile.ZipInfo,
    file: str | Path | None,
    error: type[TactileMapsError],
    max_rows: Mapping[str, int] = MappingProxyType({}),
) -> NDArray[Any]:
    """Return one array. Its stated shape is compared with the size of its bytes before they are unpacked."""
    most = max_rows.get(_SET_NUMBER.sub("", member.filename.removesuffix(".npy")), math.inf)
    with archive.open(member) as stream:
        return _read_stream(stream, place=member.filename, file=file, error=error, size=member.file_size, most=most)


def pack_array(values: NDArray[Any]) -> bytes:
    """Return an array of numbers as npy."""
    buffer = io.BytesIO()
    np.save(buffer, values, allow_pickle=False)
    return buffer.getvalue()


def unpack_array(
    data: bytes, *, place: str, file: str | Path | None = None, error: type[TactileMapsError]
) -> NDArray[Any]:
    """Return the array that ``pack_array`` packed.

    Args:
        data: The bytes, from anyone.
        place: Name of the array in errors.
        file: File that contains the array, for errors.
        error: The kind of error to raise.

    Raises:
        TactileMapsError: The bytes are not an npy, are damaged or pickled, or do not fit the shape; raised as
            ``error``.
    """
    try:
        return _read_stream(io.BytesIO(data), place=place, file=file, error=error, size=len(data))
    except ZIP_DAMAGE as cause:
        raise error("an array is damaged", file=file, place=place, value=cause) from cause


def _read_stream(
    stream: IO[bytes],
    *,
    place: str,
    file: str | Path | None,
    error: type[TactileMapsError],
    size: int,
    most: float = math.inf,
) -> NDArray[Any]:
    """Read an npy file. Unlike in NumPy, Python's parser does not read the header, as crafted headers can crash it."""
    magic = stream.read(6)
    version = (*stream.read(2),)
    if magic != b"\x93NUMPY":
        raise error("an array is damaged", file=file, place=place, value=magic)
    if version not in _LENGTH_BYTES:
        raise error("an array has an unknown format", file=file, place=place, value=version)
    length = int.from_bytes(stream.read(_LENGTH_BYTES[version]), "little")
    header = stream.read(min(length, _MAX_NPY_HEADER)).decode("latin1")
    found = _NPY_HEADER.fullmatch(header)
    if found is None:
        raise error("an array's header is damaged", file=file, place=place, value=header)
    descr = found["descr"].strip("'\"")
    if not _NUMBER_TYPE.fullmatch(descr):
        raise error(
            "only arrays of numbers are allowed",
            file=file,
            place=place,
            value=descr,
            remedy="Pickled objects are never read, since they can run code",
        )
    shape = tuple(int(length) for length in re.findall(r"\d+", found["shape"]))
    if shape and shape[0] > most:
        raise error(
            "an array has too many rows", file=file, place=place, value=shape[0], remedy=f"The maximum is {most:,}"
        )
    dtype = np.dtype(descr)
    stated = math.prod(shape) * dtype.itemsize
    before = 8 + _LENGTH_BYTES[version] + len(header)
    if stated != size - before or len(body := stream.read()) != stated:
        raise error("an array's shape does not fit its bytes", file=file, place=place, value=shape)
    return np.frombuffer(body, dtype).reshape(shape, order="F" if found["fortran"] == "True" else "C")
