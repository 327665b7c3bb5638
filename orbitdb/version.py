"""The version of orbitdb."""

__version__ = "0.1.0"
