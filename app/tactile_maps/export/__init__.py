"""Recordings in the formats of other programs, and running sessions in their viewers.

``export``           the formats, with one function for all of them
``tables``           contents of a recording as streamed tables; ``sinks`` write CSV, Parquet, npz or HDF5
``film``             the tactile image as a film; ``pictures`` draws one image
``lerobot``, ``rosbag``, ``rerun_file``  data sets and logs for these programs
``live_server``      a running session for Foxglove and Lichtblick; ``live_viewer`` is shared with ``live_rerun``
``live_rerun``       a running session in an open Rerun viewer; ``rerun_log`` is shared with ``rerun_file``
"""
