"""Overview of a recording without replay: ``curves`` over its length, and a ``summary`` for lists.

The curves read a few numbers of each frame, the summary a few frames of the file.
"""
