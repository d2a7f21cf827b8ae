"""The panels of the column beside the views: each shows one thing and emits what a person wants; none decides.

``panel_column`` holds all that ``registry`` lists, in the order of the window. ``maps`` has the panels of the map being
edited, ``touch`` those of what the skin reads, ``control`` those of what the arm does, ``simulation`` those of what is
simulated and what it costs; ``history_panel`` is the list of undo steps, and ``note_list`` contains the panels of
findings and messages. Their base class and controls are in
``tactile_widgets.common.panel``, their diagrams in ``tactile_widgets.plots``.
"""
