"""Sessions in files: MCAP, self-contained, readable after a crash, replayable and verifiable.

``bundle`` turns a prepared scene into attachments, ``codec`` frames and inputs into messages. ``recorder`` writes,
``reading`` reads without trust whatever is left of a file; ``player``, ``recover`` and ``verify`` stand on it.
"""
