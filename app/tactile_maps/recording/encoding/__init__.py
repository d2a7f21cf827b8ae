"""What is written into a recording, as bytes and back.

- ``frame_codec``: frames, exact to the last bit; ``frame_schema``: how viewers of other programs are told of them.
- ``message_codecs``: inputs, events, marks and failures as JSON; the list of topics.
- ``viewer_messages``: a session once more, in the messages that other programs' viewers draw.
"""
