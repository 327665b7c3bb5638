"""The topological entropy, enclosed by proof: edge words, windows, their verdicts, and what these forbid."""
