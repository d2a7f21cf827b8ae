"""Panels of the column next to the views. Each shows one thing and emits what the user requests; none decides.

``panel_column`` holds the panels that ``registry`` lists, in the order of the window. ``maps`` has the panels of the
map being edited, ``touch`` those of the readings of the skin, ``control`` those of the controller, and ``model`` those
of the skin, the simulation and its cost, findings and messages; ``history_panel`` lists undo steps.
The base class is in ``tactile_widgets.common.panel``, diagrams in ``tactile_widgets.plots``.
"""
