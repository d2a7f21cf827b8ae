"""Signals of the last seconds over time.

``history`` stores the samples, without Qt. ``trace_plots`` contains single plots of them, ``chosen_traces`` plots that
the user adds, ``group_traces`` those of a group of taxels. ``span_strip`` shows time spans of limits and events.
"""
