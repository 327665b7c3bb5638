"""Commands that look after the catalogue and the program."""
