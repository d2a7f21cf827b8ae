"""Sessions in files: MCAP, self-contained, readable after a crash, replayable and verifiable.

- ``recorder``: writes a session while it runs, or what stopped it.
- ``mcap_file``: the file: how one begins, and reading without trust whatever is left of one.
- ``messages``: all messages of a recording, and where they are; ``damage``: what one has lost.
- ``player``: a recording opened for replay.
- ``verify``: simulates it again and compares every state; ``machine``: the processor and BLAS that results depend on.
- ``recover``: salvages a recording that was cut off.
- ``annotations``: what a person says of a recording, beside it.
- ``trim``: cuts a part out into a new file.
- ``sweep_recording``: one of many recordings of a scene with varied settings.
- ``overview``: curves over a whole recording, and a summary of it.
- ``encoding``: frames, inputs and events as bytes, and what other programs' viewers read.
"""
