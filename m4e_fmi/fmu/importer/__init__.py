"""Reading and calling anyone's FMU: description, archive, messages, and the functions of FMI.

Start reading at `reading`, which makes a `Description` of the file that `opening` has checked;
`calls/` has the functions of FMI 1.0, 2.0 and 3.0. `messages` receives what FMUs log, `worker/`
runs code of FMUs where it can do no harm.
"""
