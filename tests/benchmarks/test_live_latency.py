"""Latency of readings sent by another process over the loopback interface until the window has painted them.

Measured from the time stamp in a packet to the end of the map's painting, on one clock. Because the machine may be
busy, the CPU time of the window's thread, for which a reading waits, and of all threads is stated, too. A round is the
time from one painted frame to the next.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QEventLoop, QTimer

from tactile_maps.scene.scene_file import load_scene
from tactile_maps.session.prepare import prepare
from tactile_widgets.session.backends import INLINE
from tactile_widgets.session.live_input import LiveInputSettings, ThreadReadingsRunner
from tests.widgets.support.window_driver import close_window, open_window

BACKENDS = replace(INLINE, readings_runner=ThreadReadingsRunner)
FRAMES = 150
NO_TIMES = 40
"""Number of taxels if nothing is timed."""
LONG = pytest.mark.long


def connected(window, scheme: str) -> str:
    """Connect the window; return the address to send to."""
    if scheme == "udp":
        window.live.connection.open(LiveInputSettings("udp://127.0.0.1:0"))
        return window.live.live_input.connection.source.address
    with socket.create_server(("127.0.0.1", 0)) as free:
        address = f"zmq://127.0.0.1:{free.getsockname()[1]}"
    window.live.connection.open(LiveInputSettings(address))
    return address


class Painted:
    """Ages of the readings when the map was painted [s]."""

    def __init__(self, window) -> None:
        self._window = window
        self.ages = []
        self._loop = QEventLoop()
        self._patience = QTimer(window)
        self._patience.setInterval(20_000)
        self._patience.timeout.connect(lambda: self._loop.exit(1))
        window.map_view.painted.connect(self._on_painted)

    def _on_painted(self, _tick: int) -> None:
        shown = self._window.map_view._frame.measured
        if shown is not None and shown.sent is not None:
            self.ages.append(time.time() - shown.sent)
            self._loop.quit()

    def wait(self) -> None:
        """Run Qt's event loop, as in the program."""
        self._patience.start()
        assert self._loop.exec() == 0, "nothing was painted"
        self._patience.stop()


@pytest.mark.parametrize(("taxels", "rate"), [(642, 100), pytest.param(5000, 50, marks=LONG)])
@pytest.mark.parametrize("scheme", ["udp", pytest.param("zmq", marks=LONG)])
def test_latency_from_sent_reading_to_painted_frame(benchmark, tmp_path, qapp, scheme, taxels, rate):
    scene = load_scene("arm")
    cover = replace(scene.cover, taxels=taxels if benchmark.enabled else NO_TIMES)
    prepared = prepare(replace(scene, cover=cover, stimuli=()))
    window = open_window(tmp_path, BACKENDS)
    window.live.show_prepared(prepared)
    painted = Painted(window)
    words = [
        "tactile_maps.live.sources.send",
        connected(window, scheme),
        "--taxels",
        str(len(prepared.skin)),
        "--rate",
        str(rate),
    ]
    sender = subprocess.Popen([sys.executable, "-m", *words])
    try:
        painted.wait()
        thread = []
        everything = []

        def frame() -> None:
            painted.wait()
            thread.append(time.thread_time())
            everything.append(time.process_time())

        benchmark.pedantic(frame, rounds=FRAMES, warmup_rounds=20)
        ages = 1e3 * np.array(painted.ages[-FRAMES:])
        benchmark.extra_info["taxels"] = len(prepared.skin)
        benchmark.extra_info["age"] = "median {:.0f} ms, p95 {:.0f} ms".format(*np.percentile(ages, [50, 95]))
        own, all_ = (1e3 * (times[-1] - times[0]) / max(len(times) - 1, 1) for times in (thread, everything))
        benchmark.extra_info["processor"] = f"{own:.1f} ms of the window's thread, {all_:.1f} ms of all, a frame"
    finally:
        sender.kill()
        sender.wait()
        close_window(window)
