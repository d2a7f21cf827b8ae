"""What every other folder stands on; it imports nothing of ours.

``arrays``      named array types; a value's arrays made its own and read-only
``errors``      the errors a user may meet, findings, remedies for unknown words, the crash report
``progress``    how long work says how far it is
``interrupts``  Ctrl-C that waits for what must not be left half done
``timing``      stage times by the wall clock
``weak_cache``  what is computed from a value once, for as long as it lives
``files``       bounded reads, atomic writes, text by lines, named arrays as npz
``codec``       frozen dataclasses as JSON and strictly back, by their type hints; schemas of them
``toml``        TOML that people write, with located mistakes
``plugins``     what other installed packages add
``reading_units``  what readings, and sums of them, may be called
``sparse_ldl``  sparse symmetric systems solved by LDL' factoring
"""
