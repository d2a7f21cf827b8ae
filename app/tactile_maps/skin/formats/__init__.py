"""Taxels in the files of other programs.

``taxel_set``                what every format is read into and written from: places, and whatever else a file knows
``import_skin``              the skin in any such file, on a robot or alone: the one answer for every door
``taxel_files``              reads and writes any of them; the file's ending says which
``icub_positions``           iCub skin positions (.txt), and the skin of a robot's link from them
``icub_frames``              the frames that such files state positions in
``icub_layout``              iCub layout files (.ini): the hand-drawn map of a patch
``icub_sensor_kinds``        where the pads of each kind of module lie on such a map
``icub_module_orientation``  modules of such a layout that seem turned or mirrored, and a proposal for each
``csv_table``                tables with named columns (.csv, .tsv)
``npz``                      named arrays (.npz)
``unige_json``               the robot skin library of the University of Genoa (.json)
``urdf_tactile``             sensors in URDF as tactile_toolbox defines them (.urdf)
``mujoco_touch``             MuJoCo's touch sensors, there and back (.xml)
"""
