"""What a recording holds, without replaying it: ``curves`` over its whole length, and a ``summary``.

Neither opens it as a player does: the curves take a few numbers of each frame, the summary a few frames of the file.
"""
