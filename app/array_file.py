"""Named arrays as bytes (the npz format), read without trust: no pickles, no bombs, no sizes that lie.

Skins, maps and whatever else is mostly arrays are kept this way; any tool that reads npz can open them.
"""

from __future__ import annotations

import io
import json
import math
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.errors import TactileMapsError

MAX_BYTES = 2**30
"""Of all arrays of one file together, unpacked."""
MAX_MEMBERS = 10_000
_HEADER = "header"
_READ_HEADER = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}


def pack_arrays(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """One npz of ``arrays`` and a JSON ``header``; the same input gives the same bytes."""
    text = json.dumps(header, sort_keys=True, ensure_ascii=False).encode()
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **{_HEADER: np.frombuffer(text, np.uint8)}, **arrays)
    return buffer.getvalue()


def unpack_arrays(
    data: bytes, *, file: str | Path | None = None, error: type[TactileMapsError], max_bytes: int = MAX_BYTES
) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header and the arrays of ``pack_arrays``.

    Args:
        data: The file's bytes, from anyone.
        file: Its name, for errors.
        error: The kind of error to raise.
        max_bytes: More than this unpacked is refused before unpacking.

    Raises:
        TactileMapsError: Of kind ``error``: not an npz, damaged, too large, pickled, or without a header.
    """
    arrays = unpack_bare_arrays(data, file=file, error=error, max_bytes=max_bytes)
    if _HEADER not in arrays:
        raise error("the file has no header", file=file, remedy="Open a file that this program saved")
    try:
        header = json.loads(arrays.pop(_HEADER).astype(np.uint8).tobytes())
    except (ValueError, RecursionError) as cause:
        raise error("the file is damaged or of another kind", file=file, value=cause) from cause
    if not isinstance(header, dict):
        raise error("the file's header is not an object", file=file, value=header)
    return header, arrays


def unpack_bare_arrays(
    data: bytes, *, file: str | Path | None = None, error: type[TactileMapsError], max_bytes: int = MAX_BYTES
) -> dict[str, NDArray[Any]]:
    """The arrays of an npz that any program wrote, by name; arguments and errors as ``unpack_arrays``."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = archive.infolist()
            _check_sizes(members, file, error, max_bytes)
            return {member.filename.removesuffix(".npy"): _read(archive, member, file, error) for member in members}
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, RuntimeError, TokenError) as cause:
        # A packing method that zipfile does not know is a NotImplementedError, which is a RuntimeError.
        raise error("the file is damaged or of another kind", file=file, value=cause) from cause


def _check_sizes(
    members: list[zipfile.ZipInfo], file: str | Path | None, error: type[TactileMapsError], max_bytes: int
) -> None:
    total = sum(member.file_size for member in members)
    if len(members) > MAX_MEMBERS or total > max_bytes:
        raise error(
            "the file would unpack to an absurd size",
            file=file,
            value=f"{len(members)} arrays, {total} bytes",
            remedy=f"The most is {MAX_MEMBERS} arrays and {max_bytes} bytes",
        )


def _read(
    archive: zipfile.ZipFile, member: zipfile.ZipInfo, file: str | Path | None, error: type[TactileMapsError]
) -> NDArray[Any]:
    """One array; its stated shape is compared with the bytes that are there before any memory is taken."""
    with archive.open(member) as stream:
        version = np.lib.format.read_magic(stream)
        if version not in _READ_HEADER:
            raise error("an array has an unknown format", file=file, place=member.filename, value=version)
        shape, fortran, dtype = _READ_HEADER[version](stream)
        if dtype.kind not in "fiub":
            raise error(
                "only arrays of numbers are allowed",
                file=file,
                place=member.filename,
                value=dtype,
                remedy="Pickled objects are never read, since they can run code",
            )
        body = stream.read()
    if any(n < 0 for n in shape) or math.prod(shape) * dtype.itemsize != len(body):
        raise error("an array's shape does not fit its bytes", file=file, place=member.filename, value=shape)
    return np.frombuffer(body, dtype).reshape(shape, order="F" if fortran else "C")
