"""The table of the main screen: its rows, its columns, and how to move in it."""
