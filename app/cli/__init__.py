"""The command line: ``parser`` says what may be asked, ``main`` answers with exit code and messages, ``output`` prints.

One command a file (``NAME_command``, which ``main`` imports by that name when it is asked for, so that ``--help``
answers at once); ``scenes`` finds the scene that a command means.
"""
