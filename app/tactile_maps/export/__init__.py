"""Recordings in the formats of other programs, and sessions live to their viewers.

- ``export``: the formats, and one function for all of them.
- ``tables``: what a recording holds as tables of columns, streamed; ``sinks`` takes them as CSV, Parquet, npz or HDF5.
- ``film``: the tactile image as a film; ``lerobot``, ``rosbag``, ``rerun_file``: data sets and logs of these programs.
- ``live_server``: a running session for Foxglove and Lichtblick.
- ``live_rerun``: the same for an open Rerun viewer; ``rerun_log`` is what it and ``rerun_file`` show.
- ``pictures``: the tactile image as a picture.
- ``optional``: packages that only some of them need.
"""
