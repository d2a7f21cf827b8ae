"""Studies of accuracy and time, of effects and of controllers, with the code that the window uses.

``catalogue``    names of all studies, without loading them
``study``        a study (question, cases, measurement, figures), its report, and work-precision trials
``base``         tables of rows, statistics, figures and hypotheses
``running``      runs the cases in one process or many, and continues interrupted runs
``testbeds``     bodies, touches, robots and paths with known truth
``stages``       stages of the program, each with its measurement; the window measures them on the user's skin
``budget``       best settings of several stages within a limit of time or error
``sweeps``       studies of single stages; ``map_cost`` is the command ``study map-cost``
``loop_laws``    study of the closed-form laws of sampled loops
``path_time``    studies of the shortest time for a contact path
``ablation``     cost of each effect of a scene, measured by leaving it out
``controller_comparison``  controllers with the same stimulus: traces and metrics
"""
