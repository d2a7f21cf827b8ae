"""Scripted fingers, repeatable to the last bit.

``stimulus``            properties of all kinds, and a finger's track over the skin in time
``stimulus_kinds``      poke, tap, stroke, roll, path, grasp, babble
``skin_locations``      names of places on the skin
``stimulus_player``     inputs of each tick
``stimulus_file``       stimuli as TOML
``stimuli_from_pokes``  stimuli from recorded touches of a user
"""
