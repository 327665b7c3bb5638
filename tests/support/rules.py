"""A second, naive implementation of the paper's geometric rules."""

import re


def broken_by_hand(word: str) -> list[int]:
    """Return the rules that a word breaks, by a search in three copies of it, one after the other."""
    p, text = len(word), word * 3
    found = set()
    if "00" in text or "22" in text:
        found.add(1)
    for i in range(p, 2 * p):
        if text[i] in "45" and text[i - 1] != text[i] != text[i + 1]:
            found.add(2)
    if not (set(word) & set("14") and set(word) & set("35")):
        found.add(3)
    if re.search("[14][02][14]|[35][02][35]", text):
        found.add(4)
    if any(piece in text for piece in ("14", "41", "35", "53")):
        found.add(5)
    if re.search("[14][02]{2,}[14]|[35][02]{2,}[35]", text):
        found.add(6)
    return sorted(found)
