"""A package that is not there is named with its remedy."""

from __future__ import annotations

import pytest

from app.core.errors import ExportError
from app.export.optional import optional_package


def test_what_is_there_is_imported_and_what_is_not_is_named():
    assert optional_package("json", extra="export").dumps([1]) == "[1]"
    with pytest.raises(ExportError, match=r"no_such_package.*pip install 'tactile-maps\[export\]'"):
        optional_package("no_such_package.inner", extra="export")
