"""Physics of the arm and of the fingers that press it, and the pressure its taxels feel.

``scene`` says what is simulated (its ``effects`` included), ``assemble`` compiles a model of exactly that,
``simulation`` steps it, with fingers (``poke``, ``fingers``) on the skin. ``loads`` are what presses the skin at one
instant and ``sensing`` turns them into taxel pressures. ``stimuli`` is a scripted hand, ``babbling`` one that
touches at random for maps to be learned from, ``guard`` the watchman.
"""
