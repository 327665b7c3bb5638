"""The commands, in one folder for each panel of the help."""
