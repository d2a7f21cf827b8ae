"""Scenes: robot, skin, objects, task and outputs, and the effects that follow from them.

``scene``            everything that a session starts from
``scene_file``       scenes as TOML, by name or file; ``scene_sweep`` varies settings of one scene
``objects``          objects; ``object_meshes`` makes their surfaces
``motion``           motion of the robot through waypoints
``tasks``            tasks, outputs and needs
``effects``          all effects, and the selected ones as a value
``effect_decision``  effects that the needs require, with reasons, and what is missing
``effect_size``      size of a sensor effect relative to the contact threshold
``stability``        measured limits of stable time steps
"""
