"""One run of robot, skin, map, physics and control, tick by tick.

``prepare`` makes everything a scene needs; ``session`` runs it; each tick gives a ``frame``. ``inputs`` names what a
person may do to a session; nothing else changes it, so a recording of the inputs is a recording of the run.
"""
