"""The commands; a module holds one, or a few that belong together."""
