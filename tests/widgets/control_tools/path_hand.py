"""What tests of the path tool ask of its settings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

PIXEL = 1.5e-3
"""A little more than half a pixel of the view, across [m]."""


def shape(lead, kind):
    lead.show_settings(replace(lead.settings, path_kind=kind))


def path(lead):
    return np.array(lead.settings.path)
