"""Commands, one module each with its name; ``execute(arguments)`` runs the command and returns the exit code.

``recordings`` contains the commands that read an existing recording: replay, export, recover and trim.
"""
