"""Study of sampled loops: closed-form stability limits, settling and ripple, compared with the controllers.

``loop_laws``     the study
``sampled_loop``  the theory
``gantry``        a plate of skin on three slides under a ball
``closed_loop``   a controller in a closed loop with the gantry, with ideal joints or simulated
``step_trials``   measured responses to steps of the goal
``predictions``   measured and predicted figures
"""
