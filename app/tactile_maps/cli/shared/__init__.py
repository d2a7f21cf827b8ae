"""Shared by the commands.

``output``, ``damage``  facts, progress and failures as text or JSON; rows about a damaged recording
``outputs``             checks of the files to write, before any work
``unused_options``      rejection of options without effect
``scenes``, ``robot_options``  the scene of a command, and options that load a robot
``recording_sweep``     ``run --sweep``
``pages``               HTML reports of single commands
``workers``             ``--jobs`` and ``--cluster``
"""
