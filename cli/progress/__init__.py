"""How far a command is: the line on stderr, and the pace that it tells."""
