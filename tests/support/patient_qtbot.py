"""``qtbot`` with deadlines long enough for a busy machine; a wait ends as soon as its condition holds."""

from __future__ import annotations

from functools import partialmethod

import pytest
from pytestqt.qtbot import QtBot

PATIENCE_MS = 60_000


class PatientQtBot(QtBot):
    """``QtBot`` with longer default deadlines."""

    waitUntil = partialmethod(QtBot.waitUntil, timeout=PATIENCE_MS)
    waitSignal = partialmethod(QtBot.waitSignal, timeout=PATIENCE_MS)
    waitSignals = partialmethod(QtBot.waitSignals, timeout=PATIENCE_MS)
    waitExposed = partialmethod(QtBot.waitExposed, timeout=PATIENCE_MS)
    waitActive = partialmethod(QtBot.waitActive, timeout=PATIENCE_MS)
    waitCallback = partialmethod(QtBot.waitCallback, timeout=PATIENCE_MS)


@pytest.fixture
def qtbot(qapp, request):
    """Return a ``PatientQtBot``, in place of pytest-qt's."""
    return PatientQtBot(request)
