"""Overview of a recording without replay: ``curves``, the ``raster`` of all taxels, and a ``summary`` for lists.

The curves read a few numbers of each frame, the raster all pressures, the summary a few frames of the file.
"""
