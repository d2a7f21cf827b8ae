"""Processes beside the window, so that it never waits; ``jobs`` is taking their place.

``worker_process`` is one process: requests go in, answers come out as a signal, it can be ended at any time. On it
stand ``scene_worker`` (prepares scenes, flattens patches anew), ``map_quality_worker`` (measures and compares maps),
``cost_worker`` (what effects cost, and the weight check) and ``accuracy_worker`` (work-precision diagrams).
"""
