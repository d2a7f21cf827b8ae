"""Layouts of vendors, which are recognised by their content, and other files whose fields are described by a mapping.

``documents``        content of JSON, YAML and table files as plain values
``field_mapping``    names of the fields that hold positions, ids and normals; sets of taxels from such fields
``mapping_file``     TOML file that states a mapping for another file, and a template for it
``taxel_format``     a format of taxel files, built in or of a plug-in
``paxini``           PaXini sensors (.json)
``orca``             touch sensors of the ORCA hand (.yaml)
``tactile_genesis``  probes of Tactile Genesis (.json)
``gentact``          sensors of GenTact (.urdf)
``rapid``            fingertips of the RAPID hand (.csv)
"""
