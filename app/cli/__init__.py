"""The command line: ``parser`` says what may be asked, ``main`` answers with exit code and messages, ``output`` prints.

One command a file. Commands import what they need when they run, so that ``--help`` answers at once.
"""
