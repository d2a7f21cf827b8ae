"""Scripted fingers, repeatable to the bit: what a person's fingers could do to the skin, said in a few numbers.

- ``stimulus``: what all kinds share, and a finger's track over the skin in time.
- ``stimulus_kinds``: poke, tap, stroke, roll, path, grasp, babble.
- ``skin_locations``: how a place on the skin is named and found.
- ``stimulus_player``: the inputs of each tick.
- ``stimulus_file``: stimuli as TOML.
- ``stimuli_from_pokes``: what a person did, as stimuli.
"""
