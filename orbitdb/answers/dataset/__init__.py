"""Export catalogues as datasets: a folder of tables for any tool, described by the Frictionless standard."""
