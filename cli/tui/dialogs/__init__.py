"""Dialogs: to type a line, to choose from a list, to fill the catalogue, and to show the keys."""
