"""The catalogue that the screens show; its file need not exist yet."""

from collections.abc import Sequence
from pathlib import Path

from orbitdb.orbits.orbit import Orbit, solve_word
from orbitdb.store.file.database import check_file, driver
from orbitdb.store.reading.lookup import born_with, certificate_of
from orbitdb.store.reading.moment import Reader

Certificate = tuple[float, int] | None
"""Radius and precision, in bits, of a stored proof; None if there is no proof."""
Partners = Sequence[tuple[float, list[str]]]
"""The a of each birth of a word, with the representatives of the classes born there on the same path."""


class CatalogueFile:
    """The catalogue in a file that may not exist yet."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._reader = _opened(path)

    @property
    def reader(self) -> Reader | None:
        """A reader of the catalogue; None as long as there is no file."""
        self._reader = self._reader or _opened(self.path)
        return self._reader

    def find(self, word: str, a: float) -> Orbit:
        """Return the stored orbit of a word at this a, or solve the word if it is not stored."""
        stored = None
        if self.reader is not None:
            with self.reader.moment() as moment:
                stored = moment.find(word, a)
        return solve_word(word, a) if stored is None else stored

    def a_values(self) -> list[float]:
        """Return the values of a that are in the catalogue."""
        if self.reader is None:
            return []
        with self.reader.moment() as moment:
            return moment.a_values()

    def periods(self, a: float) -> list[int]:
        """Return the periods that are filled at this a, completely or in part."""
        if self.reader is None:
            return []
        with self.reader.moment() as moment:
            return [fill.p for fill in moment.fills(a)]

    def certificate(self, orbit: Orbit) -> Certificate:
        """Return the stored proof of an orbit, if there is one."""
        if self.reader is None or not orbit.stored or orbit.length is None:
            return None
        with self.reader.moment() as moment:
            return certificate_of(driver(moment.connection), orbit.representative, orbit.a)

    def partners(self, orbit: Orbit) -> Partners:
        """Return the births of an orbit, each with the classes born there on the same path."""
        return born_with(None if self.reader is None else self.path, orbit)


def _opened(path: Path) -> Reader | None:
    return None if check_file(path) is None else Reader(path)
