"""Write the Python code on the pages into modules, one per page, for type checkers.

python docs/examples.py FOLDER
"""

import sys
from pathlib import Path

from pages import PAGES, examples


def write_modules(folder: Path) -> list[Path]:
    """Write a module for every page with Python code, named after the page; return the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for page in PAGES:
        parts = [example.source for example in examples(page) if example.language == "python"]
        if parts:
            made.append(folder / f"{page.stem.lower().replace('-', '_')}_page.py")
            made[-1].write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    return made


if __name__ == "__main__":
    print(*write_modules(Path(sys.argv[1])), sep="\n")
