"""Recordings state the processor and the BLAS kernel that their last digits depend on."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

from tactile_maps.recording.machine import machine_facts
from tactile_maps.recording.player import RecordingPlayer


def test_recording_states_processor_and_blas(recording):
    facts = machine_facts()
    assert facts.keys() == {"cpu", "blas"}
    assert all(facts.values())
    assert facts.items() <= RecordingPlayer(recording).versions.items()


def test_active_blas_kernel_is_named():
    """OpenBLAS can be made to use kernels of an older processor, on x86."""
    command = [
        sys.executable,
        "-c",
        "from tactile_maps.recording.machine import machine_facts; print(machine_facts()['blas'])",
    ]
    kernels = []
    for variables in ({}, {"OPENBLAS_CORETYPE": "Nehalem"}):
        done = subprocess.run(command, env=os.environ | variables, capture_output=True, text=True, check=True)
        kernels.append(done.stdout.strip())
    assert kernels[0] == machine_facts()["blas"]
    if "openblas" in kernels[0] and platform.machine() in ("x86_64", "AMD64") and sys.platform == "linux":
        assert kernels[1].endswith("kernel Nehalem")
