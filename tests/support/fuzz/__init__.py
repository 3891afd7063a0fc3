"""Fuzzing of all readers of files: valid files with damage, and what becomes of them.

`families` has the seeds of each family of files; `trees`, `texts`, `archives` and `binaries` damage
them by their structure and by their bytes; `cases` gives one damaged file to one command and says
what is wrong with the outcome; `campaign` runs many cases in processes that may crash, resumably.
"""
