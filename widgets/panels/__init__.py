"""The panels of the column beside the views: each shows one thing and emits what a person wants; none decides.

``panel_column`` holds all of them, in the order of the window: ``controller_panel``, ``contacts_panel``,
``events_panel``, ``behaviours_panel``, ``patches_panel`` (with ``patch_list``, its tree of patches), ``quality_panel``,
``compare_panel``, ``history_panel``, ``accuracy_panel``, ``timing_panel`` and ``effects_panel``. Their base class and
controls are in ``widgets.common.panel``, their diagrams in ``widgets.plots``.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
