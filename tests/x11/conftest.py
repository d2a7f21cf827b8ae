"""X server for each test with a real mouse, and the app on it. Without the required tools the tests are skipped."""

from __future__ import annotations

import os
import shutil
import subprocess

import pytest

from tests.x11.real_app import RealApp

MISSING = [tool for tool in ("Xvfb", "xdotool") if shutil.which(tool) is None]


def pytest_collection_modifyitems(items):
    """Mark every test in this folder, and skip all if a tool is missing."""
    skip = pytest.mark.skip(reason=f"needs {', '.join(MISSING)} (apt-get install xvfb xdotool)")
    for item in items:
        if "/x11/" in str(item.path):
            item.add_marker(pytest.mark.x11)
            if MISSING:
                item.add_marker(skip)


@pytest.fixture
def screen():
    """Start an X server, which chooses its own number."""
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
        pass_fds=(writing,),
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    with os.fdopen(reading) as output:
        number = output.readline().strip()
    assert number, "Xvfb did not start"
    yield f":{number}"
    server.terminate()
    server.wait()


@pytest.fixture
def app(screen, tmp_path, request):
    """Run the app with the test file's ``SCRIPT``."""
    made = RealApp(screen, tmp_path, request.module.SCRIPT)
    yield made
    made.close()
