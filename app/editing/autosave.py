"""Where a document is kept, what has not been saved, and a copy beside the file that outlives a crash."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from app.editing.document import MapDocument
from app.editing.document_file import load_document, save_document
from app.errors import MapError

ENDING = ".autosave"


@dataclass(frozen=True)
class Recovery:
    """An autosave that is newer than what was saved: the program ended without a goodbye.

    Attributes:
        file: The autosave; ``load_document`` reads it.
        newer: By how much [s]; inf if nothing was ever saved.
    """

    file: Path
    newer: float


class DocumentFile:
    """The file of one document. Mutable: knows which document is on the disk.

    Args:
        path: Where ``save`` writes; None for a document that has no file yet, then with ``folder``.
        saved: The document that is on the disk; None if there is none.
        folder: Where a document without a file is autosaved.

    Attributes:
        path: As above.
    """

    def __init__(self, path: Path | None, saved: MapDocument | None, *, folder: Path | None = None) -> None:
        self.path, self._saved, self._folder = path, saved, folder
        self._autosaved: MapDocument | None = None

    @classmethod
    def open(cls, path: str | Path) -> tuple[DocumentFile, MapDocument]:
        """A document and its file. Ask ``recovery`` before working on.

        Raises:
            MapError: As ``load_document``.
        """
        document = load_document(path)
        return cls(Path(path), document), document

    def unsaved(self, document: MapDocument) -> bool:
        """Whether closing now would lose something: ``document`` is not the one on the disk. Undone to it, it is."""
        return document is not self._saved

    def save(self, document: MapDocument) -> None:
        """Write to ``path``; the autosave is then no longer needed.

        Raises:
            MapError: There is no path yet, or it cannot be written; nothing is lost then.
        """
        if self.path is None:
            raise MapError("the map has no file yet", remedy="Save it under a name")
        save_document(document, self.path)
        self._saved = document
        self.drop_autosave()

    def save_as(self, document: MapDocument, path: str | Path) -> None:
        """Write to ``path``, which is the document's file from now on.

        Raises:
            MapError: It cannot be written; the document keeps its old file.
        """
        save_document(document, path)
        self.drop_autosave()
        self.path, self._saved = Path(path), document

    @property
    def autosave_file(self) -> Path | None:
        """Beside the file, or in the folder for documents without one; None if there is neither."""
        if self.path is not None:
            return self.path.with_name(self.path.name + ENDING)
        return None if self._folder is None else self._folder / f"untitled.npz{ENDING}"

    def autosave(self, document: MapDocument) -> bool:
        """Keep ``document`` beside the file if that is worth it; whether it was written.

        May run in another thread, in order with ``save``: compressing lets the window go on.

        Raises:
            MapError: It cannot be written.
        """
        file = self.autosave_file
        if not self.unsaved(document):
            self.drop_autosave()
            return False
        if file is None or document is self._autosaved:
            return False
        save_document(document, file)
        self._autosaved = document
        return True

    def recovery(self) -> Recovery | None:
        """What an earlier run left; None if it ended well, or saved later than it autosaved.

        Raises:
            MapError: The folder cannot be read.
        """
        file = self.autosave_file
        try:
            if file is None or not file.exists():
                return None
            if self.path is None or not self.path.exists():
                return Recovery(file, float("inf"))
            newer = file.stat().st_mtime - self.path.stat().st_mtime
        except OSError as error:
            raise MapError("the autosave cannot be read", file=file, value=error) from error
        return Recovery(file, newer) if newer > 0 else None

    def drop_autosave(self) -> None:
        """Forget the autosave, as a person does who does not want it back.

        Raises:
            MapError: It cannot be removed.
        """
        file, self._autosaved = self.autosave_file, None
        try:
            if file is not None:
                file.unlink(missing_ok=True)
        except OSError as error:
            raise MapError("the autosave cannot be removed", file=file, value=error) from error
