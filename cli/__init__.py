"""The command line and the terminal UI of orbitdb."""
