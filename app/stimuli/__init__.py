"""A scripted hand, repeatable to the bit: what a person's fingers could do to the skin, said in a few numbers.

``stimulus`` is what all kinds share, ``place`` how a place on the skin is said and found, ``track`` one finger's way
over the skin in time: every kind becomes a few tracks. The kinds: ``poke``, ``stroke``, ``tap``, ``roll``, ``grasp``,
``babble`` (chance, seeded) and ``path`` (point by point, as a hand went). ``player`` turns them into the inputs of each
tick, ``stimulus_file`` reads and writes them as TOML, and ``from_hand`` says what a person did in the same lines.
"""
