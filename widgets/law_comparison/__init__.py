"""Several laws side by side, in a window of its own: chosen, run beside the simulation, drawn over each other.

Read ``comparer`` (the process that runs them), ``contender_card`` and ``stimulus_choice`` (what is asked), ``overlaid``
and ``figures_table`` (what came of it), ``board`` (all of it together), ``comparing`` (what connects it to the window).
"""
