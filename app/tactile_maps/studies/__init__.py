"""What accuracy costs in time, what each effect costs, and how controllers compare: measured with the code that the
window runs.

Read in this order:

``work_precision``  what a stage of the program is, a setting of it, and a trial of that: errors and milliseconds
``stages``      the stages, each with what measures a trial; the window tries them on the user's own skin
``budget``      the best settings of several stages within a limit of time or error
``testbeds``    bodies, touches, pressed robots and paths whose truth is known
``study``       what a study is: a question, its cases, how one is measured
``running``     measures the cases in one process or many, keeps them as they come and goes on later
``sweeps``      the studies themselves, one a file, called as the command line calls them (``map_cost`` is ``study
                map-cost``); those of a stage make its trials on testbeds
``loop_laws``   the study of the closed-form laws of sampled loops
``hypotheses``  what theory expects of a study's rows, and whether it held
``path_time``   the studies of the least time for a contact path, by how the skin is known and how it feels
``rows``        tables of studies, and statistics;  ``reporting`` draws and writes them;  ``catalogue`` names all
                studies, without loading them
``ablation``    what each effect of a scene costs, by leaving it out
``controller_comparison``  several controllers on the same stimulus: traces and metrics
"""
