"""What `verify` says of a file."""

from pathlib import Path
from typing import Any

from orbitdb.catalogue.catalogue import Catalogue
from orbitdb.store.asking.selection import Selection
from orbitdb.verification.check import Check
from orbitdb.verification.verify import report, verify


def checks(path: Path, selection: Selection | None = None, **options: Any) -> dict[str, Check]:
    steps = verify(Catalogue(path), [selection or Selection()], **options)
    return {check.name: check for check in report(steps)}
