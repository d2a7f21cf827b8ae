"""Recordings: sessions in self-contained MCAP files that survive a crash and can be replayed and verified.

``recorder``         writes a running session, or the report of a failed one
``player``           opens a recording for replay
``verify``           simulates a recording again and compares every state; ``machine`` identifies processor and BLAS
``file``             the MCAP file: reading without trust, messages, damage, locking
``encoding``         frames, inputs, events and annotations as bytes, and messages for viewers
``overview``         curves and a summary without replay
``recover``          saves the intact part of a damaged recording
``trim``             copies a part into a new file
``sweep_recording``  one of many recordings of a scene with varied settings
"""
