"""Figures of the command `plot`, from what the catalogue holds."""
