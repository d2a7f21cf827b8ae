"""One run of robot, objects, skin, map, physics and control, tick by tick.

``prepare`` makes everything a scene needs; ``session`` runs it; each tick gives a ``frame``. ``inputs`` names what a
person may do to a session; nothing else changes it, so a recording of the inputs is a recording of the run. Where the
physics gives up, ``failure`` says so with the inputs that led there. ``price`` measures what each effect costs;
``sensor_facts`` is what the controller is told of the sensor.
"""
