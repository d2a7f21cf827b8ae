"""Plots of live signals, and work-precision diagrams.

``traces`` are signals over time: the last seconds of all that is plotted, and single plots of them; ``live_plots`` puts
these side by side and shows those that were chosen. ``plot_canvas`` is what every plot is drawn on.
``work_precision_plot`` is error against time, both logarithmic; ``study_plot`` is what a study measured against a
factor; ``curve_legend`` has the colours and markers by which curves are told apart.
"""
