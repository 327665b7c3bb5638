"""The screens with statistics of the chosen subset: averages by period, and counts with a histogram."""
