"""Sessions: runs of a prepared scene, tick by tick.

``prepare``            makes everything that a scene needs; ``prepared_cache`` keeps it on disk, ``program_digest``
                       identifies the program that made it, and ``bundle`` attaches it to a recording
``session``            runs a prepared scene
``frame``              frozen result of a tick, with the values that a real skin sent, or a ``Failure``
``inputs``             everything that may change a session; recorded inputs reproduce the run
``input_log``          compact log of the inputs
``runtime_settings``   settings at one instant
``reference_run``      the same inputs simulated with finer steps, and the difference
``obstacles``          objects of a scene as obstacles for motion planning
``link_levels``        coarser meshes of links for drawing
"""
