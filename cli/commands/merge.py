"""``orbitdb merge``: join catalogues that were filled apart."""

from pathlib import Path
from typing import Annotated

import typer

from orbitdb.cli import options
from orbitdb.cli.notes import note, progress
from orbitdb.cli.output import Output
from orbitdb.cli.snapshots import bring
from orbitdb.text import several

EXAMPLES = ("merge part-*.db --db all.db",)
COLUMNS = ("part", "a", "periods", "words", "other")


def merge(
    *,
    parts: Annotated[
        list[Path],
        typer.Argument(metavar="PART...", parser=options.read_path, help="Catalogues to copy from."),
    ],
    output: Output,
    db: options.Database,
) -> None:
    """Copy into the catalogue what it lacks and others have, such as the parts that a job array has filled.

    Periods come over whole, or as far as they are filled, with single words, births, sweeps, levels, bounds,
    averages over trajectories and proofs. Each part is copied in one transaction. A part that contradicts
    the catalogue is refused. words counts the words that were added.
    """
    from orbitdb.catalogue import Catalogue

    bring(db)
    with progress("merging") as shown:
        added = Catalogue(db).merge(parts, progress=shown)
    output.write(COLUMNS, added)
    if not added:
        note(f"{db} has everything in {several(len(parts), 'part')}: nothing to add")
