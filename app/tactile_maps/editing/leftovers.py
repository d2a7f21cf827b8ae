"""Autosaves that remain after a crash: found in the folders of one robot, and claimed until a person decides."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from tactile_maps.core.errors import MapError, TactileMapsError
from tactile_maps.core.files import MAX_UNPACKED_BYTES, FolderClaim, claim_folders_with, read_bounded_file
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import AUTOSAVE_NAME, about_from_bytes, document_from_bytes


@dataclass(frozen=True, eq=False)
class Leftover:
    """An autosave of a process that has ended. No other process can claim it before ``release`` or ``discard``.

    Attributes:
        claim: The folder that contains it.
        document: The document.
        file: Map file of the document; None if it had none.
        scene: Text of the scene that its skin needs; empty if that was saved.
        cover: Text of the cover that was chosen for its skin but not applied; empty without one.
        unopened: Text of a scene whose skin was chosen before it was opened; empty without one.
        unchosen: Text of the cover that this scene has without the choice; empty without one.
        written: Time of the autosave [s since 1970].
        name: Name of the document.
        opened: Text of the scene that was opened for the document; empty if its skin was in no file.
        opened_file: File of that scene; empty if it had none.
    """

    claim: FolderClaim
    document: MapDocument
    file: Path | None
    scene: str
    cover: str
    unopened: str
    unchosen: str
    written: float
    name: str = ""
    opened: str = ""
    opened_file: str = ""

    @property
    def openable(self) -> bool:
        """Whether the autosave states how to open its document."""
        return bool(self.name and (self.opened or self.scene))

    @property
    def newer_than_file(self) -> bool:
        """Whether the map file still exists and was not written after the autosave."""
        try:
            return self.file is not None and self.file.stat().st_mtime <= self.written
        except OSError:
            return False

    def release(self) -> None:
        """Release the claim, so that another process can offer the autosave."""
        self.claim.release()

    def discard(self) -> None:
        """Delete the autosave.

        Raises:
            MapError: It cannot be deleted.
        """
        path = self.claim.folder / AUTOSAVE_NAME
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise MapError("the autosave cannot be removed", file=path, value=error) from error
        finally:
            self.claim.release()


def find_leftovers(parent: Path) -> list[Leftover]:
    """Claim the autosaves in the folders of ``parent`` that no running process has, the newest first.

    A damaged autosave is left in place.

    Raises:
        OSError: A folder cannot be read.
    """
    found = []
    for claim in claim_folders_with(parent, AUTOSAVE_NAME):
        path = claim.folder / AUTOSAVE_NAME
        leftover = None
        with suppress(TactileMapsError, OSError):
            data = read_bounded_file(path, error=MapError, most=MAX_UNPACKED_BYTES)
            about = about_from_bytes(data, file=path)
            file = Path(about["file"]) if about.get("file") else None
            document = document_from_bytes(data, file=path)
            texts = about.get("scene", ""), about.get("cover", ""), about.get("unopened", ""), about.get("unchosen", "")
            origin = about.get("name", ""), about.get("opened", ""), about.get("opened_file", "")
            leftover = Leftover(claim, document, file, *texts, path.stat().st_mtime, *origin)
        if leftover is None:
            claim.release()
        else:
            found.append(leftover)
    return sorted(found, key=lambda leftover: -leftover.written)


def leftovers_of_all(root: Path) -> list[Leftover]:
    """Return the autosaves of all robots in ``root`` that no running process has, the newest first, without claims.

    Raises:
        OSError: A folder cannot be read.
    """
    folders = [path for path in root.iterdir() if path.is_dir()] if root.is_dir() else []
    found = [leftover for folder in folders for leftover in find_leftovers(folder)]
    for leftover in found:
        leftover.release()
    return sorted(found, key=lambda leftover: -leftover.written)
