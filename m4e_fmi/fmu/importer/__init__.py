"""Reading and calling anyone's FMU: description, archive, messages, and the functions of FMI."""
