"""Sessions in files: MCAP, self-contained, readable after a crash, replayable and verifiable.

``bundle`` turns a prepared scene into attachments, ``codec`` frames, inputs and failures into messages
(``effects_codec`` the effects in them). ``recorder`` writes, ``reading`` reads without trust whatever is left of a
file; ``player``, ``recover`` and ``verify`` stand on it. ``report`` keeps what stopped a session, to see it stop again.
"""
