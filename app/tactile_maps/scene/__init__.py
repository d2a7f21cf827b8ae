"""What a scene is: robot, skin, objects, task and wanted outputs, and the effects that follow from these.

- ``scene``: everything a session starts from.
- ``scene_file``: scenes as TOML, by name or file.
- ``scene_sweep``: many scenes from one, by what a sweep file varies.
- ``objects``: the objects in it; ``object_meshes``: their surfaces.
- ``motion``: the robot's own motion through waypoints.
- ``tasks``: what a scene is for: tasks, outputs, needs.
- ``effects``: every effect there is, and what is simulated.
- ``effect_decision``: which effects the needs call for and why, and what is missing then.
- ``stability``: which time steps hold which contacts, as measured.
"""
