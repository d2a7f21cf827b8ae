"""A study and its results.

``study``           question, cases, measurement and figures
``report``          tables (CSV, JSON, Parquet) and a self-contained HTML page
``work_precision``  a stage of the program, its settings, and trials with errors and times
"""
