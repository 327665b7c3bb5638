"""Words: their symmetries, the geometric pruning rules, and how words are enumerated and counted."""
