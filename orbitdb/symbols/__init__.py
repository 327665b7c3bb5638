"""Words: their symmetries, the pruning rules, enumeration and counting."""
