"""Experiments: what accuracy costs in time, asked of the same code that the window runs.

Each answers one question and is one file: ``image_cost`` (which interpolation, at how many taxels and pixels),
``map_cost`` (which way of laying flat, with how many seams, on how fine a mesh), ``touch_cost`` (which contact model,
for how many taxels and how small a contact; its truth is ``dense_touch`` on ``touch_skins``, and ``touch_physics``
reads the models that make their own force). ``names`` and ``table`` list them. They are run by ``sweep`` (cases in
parallel, with progress and cancel) on bodies from ``meshes``, and told by ``report`` (CSV, JSON and one HTML page) with
the curves of ``plot`` on a ``machine`` that is named.

``control_laws`` compares the laws on the same paths, robots and sensors, each with a gain that ``arm_loop`` allows.
``control_theory`` holds them to the theory of sampled loops: ``sampled_loop`` predicts, ``control_loops`` measures on a
plate of skin (``gantry``, ``gantry_loop``), ``theory_rows`` and ``theory_figures`` put both side by side.

``work_precision`` asks the same of the user's own skin, in seconds: the settings of each of the ``stages`` are tried,
and the window draws what came out and lets a person choose by it.
"""
