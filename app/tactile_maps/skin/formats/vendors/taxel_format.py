"""A format of taxel files that is recognised by its suffix, or by its content where other formats share the suffix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tactile_maps.core.errors import Finding, errors_in_file
from tactile_maps.skin.formats.vendors.documents import content_of
from tactile_maps.skin.formats.vendors.field_mapping import FieldMapping, taxel_sets_of
from tactile_maps.skin.model.taxel_set import TaxelSet


@dataclass(frozen=True)
class TaxelFormat:
    """Format of taxel files, of a vendor or of a plug-in.

    Attributes:
        name: Name in lists of plug-ins.
        title: Displayed name.
        endings: Suffixes of its files in lower case, with their dots.
        read: Returns the sets of taxels in a file, one for each link; raises a ``SkinError`` for invalid files.
        recognises: Returns whether the content of a file is of this format. It receives the values of a JSON or YAML
            file, a dictionary by heading for each row of a CSV or TSV file, and the text of any other file. None for a
            format whose suffixes no other format has.
    """

    name: str
    title: str
    endings: tuple[str, ...]
    read: Callable[[Path], tuple[TaxelSet, ...]]
    recognises: Callable[[object], bool] | None = None


def read_with(mapping: Callable[[object], FieldMapping], assumed: str) -> Callable[[Path], tuple[TaxelSet, ...]]:
    """Return the function that reads files of a vendor by the mapping for their content.

    Args:
        mapping: Returns the mapping for the values of a file.
        assumed: What is assumed about every file, for the finding ``vendor-layout``.
    """

    def read(path: Path) -> tuple[TaxelSet, ...]:
        document = content_of(path)
        with errors_in_file(path):
            first, *others = taxel_sets_of(document, mapping(document), name=path.stem, where=path.name)
        count = sum(map(len, (first, *others)))
        return (first.with_findings(Finding("vendor-layout", path.name, assumed, count)), *others)

    return read
