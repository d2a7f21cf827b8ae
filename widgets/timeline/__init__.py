"""What is being recorded, and recordings to play, scrub and step through.

``playhead`` is the rule of where a replay stands, without Qt; ``timeline`` draws it with its bar, buttons and keys.
Neither reads a clock: whoever plays passes the elapsed time in.
"""
