"""The open stadium: what escapes through openings of its boundary or by patterns, and how fast."""
