"""The file of a recording.

``recording_file``  output file: locked while it is written, replaced only by a complete one
``mcap_file``       MCAP records: writing, and reading without trust
``messages``        all messages of a recording and their positions
``damage``          losses found by sequence numbers and checksums
"""
