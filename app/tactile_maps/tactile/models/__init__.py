"""Contact models: from loads to taxel pressures, one a file. ``contact_model`` is what all answer, and lists them by
name.

In order of what they know: ``point`` a force and a place, ``water_fill`` also the body's shape, ``punch`` also the
moment, ``half_space`` also the cover between surface and taxel. ``foundation`` makes the force itself, from the body's
depth in an elastic layer; ``depth`` is MuJoCo's own sensor, for comparison.
"""
