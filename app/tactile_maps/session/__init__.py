"""One run of robot, objects, skin, map, physics and control, tick by tick.

- ``prepare``: makes everything a scene needs; opens and checks a person's own scene file.
- ``session``: runs it.
- ``frame``: what each tick answers; a ``Failure`` where the physics gives up.
- ``inputs``: what a person may do to a session; nothing else changes it, so a recording of the inputs is a recording
  of the run.
- ``input_log``: those of a session in order, kept small.
- ``reference_run``: the session once more from the same inputs, finer, and by how much it differs.
- ``runtime_settings``: the settings in force at one instant.
"""
