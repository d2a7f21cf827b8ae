"""Findings as warnings of a command, without the notes that every healthy robot has."""

from __future__ import annotations

from collections.abc import Sequence

from tactile_maps.core.errors import Finding

_MODEL_NOTES = frozenset(("armature", "damping", "home-chosen", "mimic-joints", "touching-links", "unnamed", "xacro"))
"""Kinds of findings that state how a robot's file was completed. ``inspect`` lists them."""


def without_model_notes(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings that are not notes about the robot's model."""
    return [finding for finding in findings if finding.kind not in _MODEL_NOTES]


def model_notes_text(findings: Sequence[Finding], source: str) -> str:
    """Return one line with the number of notes about the robot's model; empty without notes.

    Args:
        findings: All findings.
        source: File or name of the robot.
    """
    count = len(findings) - len(without_model_notes(findings))
    notes = f"{count} notes" if count > 1 else "1 note"
    return f"{notes} about the model: tactile-maps inspect {source}" if count else ""
