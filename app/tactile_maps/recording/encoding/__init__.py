"""Contents of a recording as bytes and back.

``frame_codec``      frames, exact to the last bit; ``frame_schema`` describes them to other viewers
``message_codecs``   inputs, events, marks and failures as JSON; the list of topics
``annotations``      marks, episodes and outcomes that a user adds
``viewer_messages``  messages that viewers of other programs draw
"""
