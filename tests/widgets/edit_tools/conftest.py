"""What every tool is tried on: a tube, a sheet and a cap, edited by a worker that answers at once or when let go."""

from __future__ import annotations

import pytest

from tests.widgets.map_hand import open_editor, small_document
from widgets.worker import InlineWorker


@pytest.fixture(scope="module")
def document():
    return small_document()


@pytest.fixture
def worker(request):
    """Parametrized indirectly, of that kind."""
    return getattr(request, "param", InlineWorker)()


@pytest.fixture
def editor(worker, document):
    return open_editor(worker, document)
