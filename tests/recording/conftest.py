"""A small arm and a recording of it, made once."""

from __future__ import annotations

import pytest

from tests.support.recordings import record, small_arm


@pytest.fixture(scope="package")
def prepared():
    return small_arm()


@pytest.fixture(scope="package")
def recording(prepared, tmp_path_factory):
    """200 frames, begun 50 ticks after the session."""
    path = tmp_path_factory.mktemp("recording") / "demo.mcap"
    record(prepared, path, ticks=200, start=50)
    return path
