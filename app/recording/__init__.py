"""Sessions in files: MCAP, self-contained, readable after a crash, replayable and verifiable.

``bundle`` turns a prepared scene into attachments; ``frame_codec`` (with ``estimate_codec``), ``input_codec`` (with
``effects_codec``), ``event_codec`` and ``failure_codec`` make messages, which ``topics`` lists. ``recorder`` writes,
``reading`` reads without trust whatever is left of a file; ``player``, ``recover`` and ``verify`` stand on it.
``report`` keeps what stopped a session, to see it stop again.
"""
