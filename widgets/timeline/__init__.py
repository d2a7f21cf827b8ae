"""Time under the hand: what is being recorded, and recordings to play, scrub and step through.

``playhead`` is the pure rule of where a replay stands; ``scrub_bar`` draws it and follows the mouse; ``timeline`` puts
buttons, keys and both together. None of them reads a clock: whoever plays passes the elapsed time in.
"""
