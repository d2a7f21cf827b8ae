"""The stages whose accuracy and time are measured on the user's own skin, each one file.

``cut`` (how many seams), ``flatten`` (which method), ``image`` (which interpolation, how many pixels), ``touch`` (which
contact model) and ``simulation`` (which integrator, how long a time step). What the first two have in common is in
``laid``: charts made by the clock, and judged. ``table`` lists them; what a stage consists of is in ``work_precision``.
"""
