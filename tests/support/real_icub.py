"""Skin files of the real iCub, which cannot be included because of their licence.

Set ``ICUB_SKIN_CONF`` to the folder ``app/skinGui/conf`` of robotology/icub-main to run the tests that read them.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tactile_maps.robots.library import icub_folder

_CONF = Path(os.environ.get("ICUB_SKIN_CONF", "no such folder"))
POSITIONS = _CONF / "positions"
LAYOUTS = _CONF / "skinGui"
needs_files = pytest.mark.skipif(not POSITIONS.is_dir(), reason="ICUB_SKIN_CONF does not name iCub's skin files")
needs_icub = pytest.mark.skipif(icub_folder() is None, reason="the wheel icub-models is not installed")
