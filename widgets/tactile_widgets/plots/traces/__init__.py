"""Signals over time, of the last seconds.

``history`` keeps the samples and knows no Qt. ``trace_plots`` are single plots of them: ``chosen_traces`` are those a
person adds, ``group_traces`` those of a group of taxels; ``span_strip`` shows beneath them when something was.
"""
