"""One file a command, named as the command: ``execute(arguments)`` does it and returns the exit code."""
