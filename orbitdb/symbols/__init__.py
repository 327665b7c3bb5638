"""Symbol sequences: words, their symmetries, the pruning rules, enumeration and counting."""
