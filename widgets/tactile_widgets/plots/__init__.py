"""Plots of live signals, and work-precision diagrams.

``traces`` contains signals over time: the last seconds of everything that is plotted, and single plots of it;
``live_plots`` arranges these plots and shows the chosen ones. ``plot_canvas`` is the base widget of every plot.
``work_precision_plot`` shows error against time, both logarithmic; ``study_plot`` shows study results against a
factor; ``curve_legend`` defines the colours and markers that distinguish curves.
"""
