"""Skins and taxels in files, of this and other programs.

``identify``       kind of a file, by its suffix and content
``import_skin``    skin in a file of any format, on a robot or alone
``several_files``  one skin from several files
``taxel_files``    reads and writes all formats of taxels, by the suffix or content of the file
``vendors``        layouts of vendors, and files whose fields are described by a mapping (.json, .yaml, .csv)
``icub``           iCub skins: positions (.txt), their frames, and hand-drawn layouts (.ini)
``csv_table``      tables with named columns (.csv, .tsv)
``npz``            named arrays (.npz)
``unige_json``     robot skin library of the University of Genoa (.json)
``urdf_tactile``   sensors in URDF as defined by tactile_toolbox (.urdf)
``mujoco_touch``   MuJoCo's touch sensors, read and written (.xml)
"""
