"""Document files: a map file with the settings of each patch, validated when read.

``DocumentFile`` tracks where a document is stored and what is unsaved, and keeps an autosave that survives a crash.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tactile_maps.core.errors import MapError
from tactile_maps.core.files import (
    MAX_UNPACKED_BYTES,
    pack_arrays,
    read_bounded_file,
    unpack_arrays,
    write_atomically,
)
from tactile_maps.editing.document import MapDocument, PatchEdit
from tactile_maps.flattening.chart import Pin
from tactile_maps.flattening.cut import SeamPlan
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.formats.map_file import map_from_bytes, map_to_bytes
from tactile_maps.maps.model.layout import FARTHEST_OFFSET
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.skin import Patch
from tactile_maps.skin.model.skin_file import MAP_FORMAT

FORMAT = "tactile-maps-document"
VERSION = 1
_ROUNDING = 1e-6


def save_document(document: MapDocument, path: str | Path) -> None:
    """Write ``document`` with its map and skin to ``path`` (usually ``.npz``) atomically.

    Raises:
        MapError: The file cannot be written; an existing one is unchanged.

    Cost: 0.2 s for 1000 taxels on 27,000 faces, nearly all of it compression, which releases the GIL.
    """
    write_atomically(Path(path), document_to_bytes(document), error=MapError)


def load_document(path: str | Path) -> MapDocument:
    """Load the document that ``save_document`` wrote to ``path``, or a new one for a map of ``save_map``.

    Raises:
        MapError: The file does not exist or is not a valid document or map.
        SkinError: Its skin is not valid.
    """
    return document_from_bytes(read_bounded_file(Path(path), error=MapError, most=MAX_UNPACKED_BYTES), file=path)


def document_to_bytes(document: MapDocument, *, about: Mapping[str, str] | None = None) -> bytes:
    """Return ``document`` in the file format; equal inputs give equal bytes.

    Args:
        document: The document.
        about: Additional texts for ``about_from_bytes``, ignored when the document is read.
    """
    arrays: dict[str, NDArray[Any]] = {"map": np.frombuffer(map_to_bytes(document.map), np.uint8)}
    for i, patch in enumerate(document.patches):
        arrays[f"{i}_drawn"] = patch.seams.drawn
        if patch.seams.importance is not None:
            arrays[f"{i}_importance"] = patch.seams.importance
    patches = [
        {
            "name": patch.name,
            "method": patch.method,
            "lengths": float(patch.lengths),
            "visible": patch.visible,
            "extra": patch.seams.extra,
            "pins": [[pin.at.face, *map(float, (*pin.at.weights, *pin.place))] for pin in patch.pins],
        }
        for patch in document.patches
    ]
    header = {"format": FORMAT, "version": VERSION, "order": list(document.order), "patches": patches}
    if about is not None:
        header["about"] = dict(about)
    return pack_arrays(header, arrays)


def document_from_bytes(data: bytes, *, file: str | Path | None = None) -> MapDocument:
    """Return the document in ``data``, from ``document_to_bytes``, ``map_to_bytes`` or an untrusted source.

    Args:
        data: The file's bytes.
        file: Origin of the data, for errors.

    Raises:
        MapError: The data are damaged, malicious, of another format or version, or not a valid document.
        SkinError: Its skin is not valid.
    """
    header, arrays = unpack_arrays(data, file=file, error=MapError)
    if header.get("format") == MAP_FORMAT:
        return MapDocument.of(map_from_bytes(data, file=file))
    if header.get("format") != FORMAT:
        remedy = "Choose a file that this program saved"
        raise MapError("this is not a map", file=file, value=header.get("format"), remedy=remedy)
    if header.get("version") != VERSION:
        remedy = f"This program reads version {VERSION}"
        raise MapError("the file has an unknown version", file=file, value=header.get("version"), remedy=remedy)
    if "map" not in arrays or arrays["map"].dtype != np.uint8:
        raise MapError("the file has no map", file=file)
    map_ = map_from_bytes(arrays["map"].tobytes(), file=file)
    return MapDocument(map_, _patches(header, arrays, map_, file), _order(header, len(map_.charts), file))


def about_from_bytes(data: bytes, *, file: str | Path | None = None) -> dict[str, str]:
    """Return the texts that were passed to ``document_to_bytes`` as ``about``; empty without any.

    Raises:
        MapError: The data are damaged.
    """
    about = unpack_arrays(data, file=file, error=MapError)[0].get("about")
    return {str(key): str(value) for key, value in about.items()} if isinstance(about, dict) else {}


def _order(header: Mapping[str, Any], count: int, file: str | Path | None) -> tuple[int, ...]:
    order = header.get("order")
    if not isinstance(order, list) or any(type(k) is not int for k in order) or sorted(order) != list(range(count)):
        raise MapError("the patch tree is broken", file=file, place="order", value=order)
    return tuple(order)


def _patches(
    header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]], map_: TactileMap, file: str | Path | None
) -> tuple[PatchEdit, ...]:
    entries = header.get("patches")
    patches = map_.skin.patches
    if not isinstance(entries, list) or len(entries) != len(patches):
        raise MapError("the list of patches is broken", file=file, place="patches", value=entries)
    return tuple(_PatchReader(entries[i], arrays, i, patch, file).edit() for i, patch in enumerate(patches))


class _PatchReader:
    """Reads and validates the settings of one patch."""

    def __init__(
        self, entry: object, arrays: Mapping[str, NDArray[Any]], i: int, patch: Patch, file: str | Path | None
    ) -> None:
        self._i = i
        self._patch = patch
        self._file = file
        self._entry = entry if isinstance(entry, dict) else {}
        self._drawn = arrays.get(f"{i}_drawn")
        self._importance = arrays.get(f"{i}_importance")

    def edit(self) -> PatchEdit:
        """Return settings that an edit could have produced, so that later code need not check them."""
        name = self._take("name", lambda value: type(value) is str)
        method = self._take("method", lambda value: type(value) is str)
        lengths = self._take("lengths", lambda value: type(value) is float and 0 <= value <= 1)
        visible = self._take("visible", lambda value: type(value) is bool)
        pins = self._take("pins", lambda value: isinstance(value, list) and all(map(self._is_pin, value)))
        held = tuple(Pin(SurfacePoint(self._i, face, (a, b, c)), (x, y)) for face, a, b, c, x, y in pins)
        return PatchEdit(method, lengths, self._seams(), held, name, visible)

    def _take(self, key: str, sound: Any) -> Any:
        value = self._entry.get(key)
        if not sound(value):
            raise self._refuse(key, value)
        return value

    def _is_pin(self, value: object) -> bool:
        if not isinstance(value, list) or [type(x) for x in value] != [int, *5 * [float]]:
            return False
        face = value[0]
        weights = value[1:4]
        place = value[4:]
        return (
            0 <= face < len(self._patch.surface.faces)
            and all(0 <= w <= 1 for w in weights)
            and abs(sum(weights) - 1) <= _ROUNDING
            and all(abs(x) < FARTHEST_OFFSET for x in place)
        )

    def _seams(self) -> SeamPlan:
        surface = self._patch.surface
        drawn = self._drawn
        importance = self._importance
        extra = self._take("extra", lambda value: value is None or (type(value) is int and 0 <= value < 1000))
        if drawn is None or drawn.dtype.kind not in "iu" or drawn.ndim != 2 or drawn.shape[1] != 2:
            raise self._refuse("drawn", None if drawn is None else f"{drawn.shape} {drawn.dtype}")
        count = len(surface.vertices)
        keys = [np.sort(pairs.astype(np.int64), axis=1) @ [count, 1] for pairs in (drawn, surface.edges)]
        if not (((drawn >= 0) & (drawn < count)).all(axis=1) & np.isin(keys[0], keys[1])).all():
            raise self._refuse("drawn", "not along edges")
        if importance is not None:
            if importance.dtype.kind != "f" or importance.shape != (count,):
                raise self._refuse("importance", f"{importance.shape} {importance.dtype}")
            if not (np.isfinite(importance) & (importance >= 0)).all():
                raise self._refuse("importance", "not a number from 0 up")
        return SeamPlan(extra, drawn, importance)

    def _refuse(self, key: str, value: object) -> MapError:
        return MapError("the file is broken", file=self._file, place=f"patch {self._patch.name}, {key}", value=value)


AUTOSAVE_ENDING = ".autosave"
UNTITLED = "untitled.npz"
"""Name of a document that has no file yet."""
AUTOSAVE_NAME = f"{UNTITLED}{AUTOSAVE_ENDING}"
"""Name of an autosave in a folder of its own."""


def _signature(path: Path | None) -> tuple[int, ...] | None:
    """Return inode, size and time of a file, which change when it is written; None if it does not exist."""
    try:
        found = None if path is None else path.stat()
    except OSError:
        return None
    return None if found is None else (found.st_ino, found.st_size, found.st_mtime_ns)


class DocumentFile:
    """File of one document. Mutable: tracks which document is on the disk.

    Args:
        path: The file; None for a document that has none yet, then with ``folder``.
        saved: The document on the disk; None if there is none.
        folder: Folder of the autosave; by default next to the file.

    Attributes:
        path: The file.
    """

    def __init__(self, path: Path | None, saved: MapDocument | None, *, folder: Path | None = None) -> None:
        self.path = path
        self._saved = saved
        self._folder = folder
        self._autosaved: tuple[MapDocument, dict[str, str]] | None = None  # with the texts that accompany it
        self._signature = _signature(path)

    @property
    def saved(self) -> MapDocument | None:
        """The document on the disk; None if there is none."""
        return self._saved

    def mark_saved(self, document: MapDocument) -> None:
        """Record that ``document`` can be recreated from another file, such as its scene."""
        self._saved = document

    def resume(self) -> None:
        """Write the next autosave even without a change, because another document used the folder meanwhile."""
        self._autosaved = None

    def unsaved(self, document: MapDocument) -> bool:
        """Return whether closing now would lose changes: whether ``document`` is not the one on the disk."""
        return document is not self._saved

    @property
    def changed_elsewhere(self) -> bool:
        """Whether another window or program has written, or removed, the file since it was read or saved here."""
        return _signature(self.path) != self._signature

    def save_as(self, document: MapDocument, path: str | Path) -> None:
        """Write to ``path``, which becomes the document's file, and delete the autosave. See ``changed_elsewhere``.

        Raises:
            MapError: The file cannot be written; the document keeps its old file.
        """
        save_document(document, path)
        self.drop_autosave()
        self.path = Path(path)
        self._saved = document
        self._signature = _signature(self.path)

    @property
    def autosave_file(self) -> Path | None:
        """Path of the autosave in the folder, or else next to the file; None if there is neither."""
        if self._folder is not None:
            return self._folder / AUTOSAVE_NAME
        return None if self.path is None else self.path.with_name(self.path.name + AUTOSAVE_ENDING)

    def autosave(
        self,
        document: MapDocument,
        *,
        scene: str = "",
        cover: str = "",
        unopened: str = "",
        unchosen: str = "",
        origin: Mapping[str, str] | None = None,
    ) -> bool:
        """Write an autosave if the document or its scene has unsaved changes. Return whether it was written.

        Args:
            document: The document.
            scene: Text of its scene if that has changes that are not saved; else empty.
            cover: Text of a cover that is chosen for its skin but not applied; empty without one.
            unopened: Text of a scene whose skin is chosen before it is opened; empty without one.
            unchosen: Text of the cover that this scene has without the choice; empty without one.
            origin: Texts that name the document and state how to open it: ``name``, ``opened`` and ``opened_file`` of
                ``Leftover``.

        May run in another thread, in order with ``save_as``; compression does not block the window.

        Raises:
            MapError: It cannot be written.
        """
        file = self.autosave_file
        texts = {"scene": scene, "cover": cover, "unopened": unopened, "unchosen": unchosen}
        if not self.unsaved(document) and not any(texts.values()):
            self.drop_autosave()
            return False
        if file is None or (document, texts) == self._autosaved:
            return False
        about = {"file": "" if self.path is None else str(self.path), **texts, **({} if origin is None else origin)}
        write_atomically(file, document_to_bytes(document, about=about), error=MapError)
        self._autosaved = document, texts
        return True

    def drop_autosave(self) -> None:
        """Delete the autosave.

        Raises:
            MapError: It cannot be removed.
        """
        file = self.autosave_file
        self._autosaved = None
        try:
            if file is not None:
                file.unlink(missing_ok=True)
        except OSError as error:
            raise MapError("the autosave cannot be removed", file=file, value=error) from error
