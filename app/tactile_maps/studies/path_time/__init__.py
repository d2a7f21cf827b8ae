"""Studies of the shortest time in which a contact path is followed with given errors, one factor at a time.

``representation``, ``force_feedback``  the studies, with their ``factors`` and levels
``conditions``    what a controller works with
``path_time``     cases and their measurement; ``speed_search`` finds the highest speed by bisection
``body_path``     the same path on the body for every map
``gains``         gains for slow skins, by theory
``expectations``  predictions of the theory
``charts``        figures
``replay``        the run of a row, simulated again
"""
