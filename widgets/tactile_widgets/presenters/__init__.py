"""Presenters: each connects actions, views, panels, session and document for one topic.

A presenter receives an ``AppContext`` and never the window; ``composition`` creates them in one acyclic order.
``state_tracker`` keeps the actions enabled and checked according to the state; ``view_presenter`` implements the menus
Select and View; ``notification_presenter`` reports failures, stops and saved files.

``files``    opening and saving of files, recordings, studies, exports, figures and films
``maps``     the menu Edit, and the file of the map
``session``  scenes and tick results, the menus Session, Recording and Touch, a real skin, the panels *Effects* and
             *Accuracy and time*
``control``  the menu Control, and the comparison of controllers
"""
