"""The command line: ``parser`` says what may be asked, ``main`` answers with exit code and messages, ``output`` prints.

``commands`` holds one file a command, which ``main`` imports by the command's name when it is asked for, so that
``--help`` answers at once; ``scenes`` finds the scene that a command means.
"""
