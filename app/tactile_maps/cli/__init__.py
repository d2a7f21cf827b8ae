"""Command line.

``parser``    commands and options
``main``      runs a command, with exit code and messages; imports its module only then, so that ``--help`` is fast
``commands``  one module for each command
``shared``    used by several commands: output, checks of files, scenes, robot options, worker processes
"""
