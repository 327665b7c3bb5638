"""Statistics of the chosen subset: a screen of averages and one of counts."""
