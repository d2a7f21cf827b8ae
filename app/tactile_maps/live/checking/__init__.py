"""Guided check of a real skin: its parts are pressed one after another, and a report names the faulty channels.

``parts``        parts of a skin that are pressed one at a time: modules, or groups of adjacent taxels
``skin_check``   states of the check: which part to press, what responded, what was felt
``verdicts``     faults of channels and parts, from the readings of a check
``report``       the result as a web page
"""
