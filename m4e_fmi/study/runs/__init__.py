"""Runs of any kind: what is kept of each (`record`), where (`store`), how statistics are made.

`start_up` says what they leave out.
"""
