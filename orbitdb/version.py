"""The version of orbitdb."""

__version__ = "0.2.0"
