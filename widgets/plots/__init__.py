"""Plots of live signals, and work-precision diagrams.

``history`` keeps the last seconds of all that is plotted and knows no Qt. ``plot_canvas`` is what every plot is drawn
on; ``trace_plots`` are single plots over time; ``live_plots`` puts them side by side and chooses which are shown.
``work_precision_plot`` is error against time, both logarithmic; ``study_plot`` is what a study measured against a
factor; ``curve_legend`` has the colours and markers by which curves are told apart.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
