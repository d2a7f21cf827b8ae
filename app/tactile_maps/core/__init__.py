"""Foundations without any knowledge of robots; imports nothing else of this package.

``arrays``         named array types; read-only arrays in frozen values
``errors``         errors and findings for users, suggestions for unknown words and missing packages, the crash report
``disk_cache``     entries of the cache folder, the least recently used deleted first
``files``          bounded reads, atomic writes, text by lines, named arrays as npz
``assets``         folder of robots, scenes, findings and guide pages
``file_kinds``     kinds of files with their suffixes
``codec``          frozen dataclasses to JSON and back by their type hints, and JSON schemas
``toml``           TOML files with located errors
``interrupts``     signals that end the program, deferred while a file is being completed
``progress``       reports of progress of long work
``timing``         times of stages by the wall clock
``caches``         results kept as long as an object lives, or for arrays of equal content
``plugins``        entry points of other installed packages
``reading_units``  units of readings and of their sums
``sparse_ldl``     sparse symmetric systems solved by LDL' factorization
"""
