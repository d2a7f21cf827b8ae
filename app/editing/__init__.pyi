from .document import MapDocument, PatchEdit
from .document_file import DocumentFile, load_document, save_document
from .history import History
from .reflatten import ReflattenRequest, ReflattenResult, StaleEdit, apply_result

__all__ = [
    "DocumentFile",
    "History",
    "MapDocument",
    "PatchEdit",
    "ReflattenRequest",
    "ReflattenResult",
    "StaleEdit",
    "apply_result",
    "load_document",
    "save_document",
]
