"""A package that is not there is named with its remedy."""

from __future__ import annotations

from importlib import import_module

import pytest

from tactile_maps.core.errors import ExportError
from tactile_maps.export.optional import packages_of


def test_what_is_there_is_imported_and_what_is_not_is_named():
    with packages_of("export"):
        assert import_module("json")
    with (
        pytest.raises(ExportError, match=r"no_such_package.*-m pip install .*'pyarrow>=16'"),
        packages_of("export"),
    ):
        import_module("no_such_package.inner")
