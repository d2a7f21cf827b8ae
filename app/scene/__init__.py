"""What a scene is: robot, skin, things, task and wanted outputs, and the effects that follow from these.

``scene`` holds it all; ``objects`` are the things in it and ``bodies`` what they are made of, ``motion`` the robot's
own way. ``needs`` is what the scene is for; ``effect_table`` lists every effect there is, ``rules`` says which of them
the needs call for and why, ``decide`` puts rules and a person's wishes together into ``effects``, and ``lacks`` tells
what is missing then. ``stability`` knows which time steps hold which contacts. ``scene_text`` and ``scene_file`` read
and write it all as TOML.
"""
