"""Execution of many cases, in one process or several, on one machine or many; interrupted runs continue.

``workers``      this process, or several processes of this machine; ``cluster`` uses a Dask cluster
``case_run``     measures cases that are not yet in the log and returns rows in the order of the cases
``case_log``     finished cases in a file that survives any end of the program
``sequential``   runs within a budget of time: whole seeds first, without what is settled
``tables``       rows as CSV and Parquet
``study_table``  reads such a file: factors, measures, medians and intervals
"""
