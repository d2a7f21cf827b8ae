"""The panels beside and below the views, one a file. Each shows facts and emits what the hand wants; none decides."""
