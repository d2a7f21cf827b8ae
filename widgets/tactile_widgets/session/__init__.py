"""The window's session: what is shown, and the only code that changes it.

``session_host``       opens scenes and recordings, runs a session, and reports its frames and settings
``session_run``        what can be shown: a session that runs, or a recording
``session_runner``     drives a session by the wall clock on a thread, or step by step for tests
``recording_control``  records the session that runs; ``recording_writer`` writes the file on its own thread
``replay_control``     replays a recording, and simulates on from it
``live_input``         readings of a real skin instead of a simulation; ``live_motion`` motion for the real robot
``stroke``             motion of a finger between two mouse events, tick by tick
``sharing``            live viewers of other programs
``measurements``       measurements of what is shown, in the background
``reference_comparison``  comparison with a reference run; ``skin_comparison`` of a measured with a simulated skin
``comparison_stimulus``   the stimulus on which controllers are compared
``backends``           threads and processes that do the work, or all of it inline for tests
"""
