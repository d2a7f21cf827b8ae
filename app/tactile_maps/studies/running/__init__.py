"""Long runs of many cases: in one process or several, on one machine or many, kept as they come and gone on with later.

``workers``     who measures: this process, or several of this machine
``cluster``     or those of a Dask cluster
``case_log``    the cases that are done, in a file that survives whatever ends the program
``case_run``    puts these together: what is known is not measured again; rows in the order of the cases
``sequential``  runs within a budget of time: whole seeds first, no more of what is settled
``tables``      rows as CSV and Parquet
``study_table`` such a file read back: factors, measures, and the median of each point with its interval
"""
