"""Findings of skins and taxels, by their kind."""

from __future__ import annotations


def kinds(findings):
    """Return the counts of findings by kind."""
    return {finding.kind: finding.count for finding in findings}


def by_kind(findings):
    """Return findings by kind."""
    return {finding.kind: finding for finding in findings}


def only(findings, kind):
    """Return the only finding of a kind."""
    (found,) = [finding for finding in findings if finding.kind == kind]
    return found
