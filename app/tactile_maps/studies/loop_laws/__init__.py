"""The closed-form laws of sampled loops against our controllers: limits of stability, settling, ripple.

``sampled_loop`` is the theory. ``gantry`` is a plate of skin on three slides under a ball, ``closed_loop`` closes a
controller around it, by ideal joints or simulated; ``step_trials`` measures steps of its goal, and ``predictions`` sets
each figure measured beside the one predicted. ``loop_laws`` is the study.
"""
