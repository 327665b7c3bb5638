"""Catalogue: a database of periodic orbits, opened for reading."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from orbitdb.billiard.stadium import Stadium
from orbitdb.orbits.orbit import Orbit, Status
from orbitdb.store.asking.selection import Selection, SelectionError, choose
from orbitdb.store.file.database import default_path
from orbitdb.store.file.migrate import migrate
from orbitdb.store.reading import enclosures, lives, sweeps
from orbitdb.store.reading.class_first import count_rows
from orbitdb.store.reading.counted import Counted, count
from orbitdb.store.reading.enclosures import Enclosure
from orbitdb.store.reading.fills import Fill
from orbitdb.store.reading.lives import BirthFill, Life
from orbitdb.store.reading.lookup import find_word
from orbitdb.store.reading.reader import Reader
from orbitdb.store.reading.stadiums import a_stored, meant
from orbitdb.store.reading.sweeps import Sweep
from orbitdb.symbols.words import WordError, is_primitive, parse, primitive_root

if TYPE_CHECKING:
    from orbitdb.store.reading.chosen_classes import ChosenClasses
    from orbitdb.store.reading.subset import Subset

_SOLVED = tuple(status for status in Status if status is not Status.GEOMETRIC)


class Catalogue(Reader):
    """A database of the periodic orbits of stadium billiards.

    Parameters
    ----------
    path : path-like, optional
        The file; by default ``ORBITDB_DB`` or a file in the user's data folder.
    a : float, optional
        The stadium that words and `select` are about, unless they name another; by default the only
        one of which the catalogue has orbits, else 1.6.

    Raises
    ------
    StoreError
        If there is no catalogue there, or it cannot be read by this version.

    Examples
    --------
    >>> catalogue = Catalogue("orbits.db", a=1.6)  # doctest: +SKIP
    >>> catalogue["1232131"].length, "1232131" in catalogue, len(catalogue)  # doctest: +SKIP
    >>> orbits = catalogue.select(p=(2, 11), status="orbit", lambda_c=(None, 0.4))  # doctest: +SKIP
    """

    def __init__(self, path: Path | str | None = None, a: float | None = None) -> None:
        self._a = None if a is None else Stadium(a).a
        super().__init__(path)

    def __reduce__(self) -> tuple[type["Catalogue"], tuple[Path, float | None]]:
        """Pickle, and copy, the path and a: the file is opened anew where it is loaded."""
        return type(self), (self.path.absolute(), self._a)

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> "Catalogue":
        """Open a catalogue, making it or bringing it to the newest schema first."""
        path = Path(path) if path is not None else default_path()
        migrate(path)
        return cls(path, a)

    @property
    def a(self) -> float:
        """The stadium that is meant where none is named; once it is asked for, it stays the same.

        Raises
        ------
        InputError
            If none was given, and the catalogue has orbits at several, but none at 1.6.
        """
        if self._a is None:
            with self.reading() as connection:
                self._a = meant(a_stored(connection))
        return self._a

    def partial(self, selection: Selection | None = None, **criteria: Any) -> list[Fill]:
        """Return those periods of a subset that are stored in part: a fill goes on, or was stopped.

        The parameters are those of `select`. Rows of such periods are among those that `select`,
        `classes`, `rows` and `count` give; read both in one block of `at_one_moment`.
        """
        chosen = self._chosen(selection, criteria)
        return [fill for fill in self.fills(chosen.a) if not fill.whole and chosen.includes(fill.p)]

    def unfilled(self, selection: Selection | None = None, **criteria: Any) -> str | None:
        """Say in one line which periods of a subset are not filled, what is, and what fills them.

        None if all that are named are there, if only in part (`partial`). What is not filled is not
        known to be empty. The parameters are those of `select`.
        """
        return self.gaps(self._chosen(selection, criteria))

    def find(self, word: str, a: float) -> Orbit | None:
        """Return a primitive word's stored orbit, in the rotation asked for, or None.

        Parameters
        ----------
        word : str
            Symbols 0..5, in any rotation.
        a : float
            The stadium.

        Raises
        ------
        WordError
            If it is no word.
        """
        symbols = parse(word)
        with self.reading() as connection:
            return find_word(connection, symbols, a)

    def birth_fills(self) -> list[BirthFill]:
        """Return how far births and deaths are stored, by period."""
        with self.reading() as connection:
            return lives.birth_fills(connection)

    def births(self, p: int) -> list[Life]:
        """Return from where to where in a the classes of one period are orbits, one entry a life, by birth.

        Empty if no births of the period are stored: `orbitdb births` stores them.
        """
        with self.reading() as connection:
            return lives.lives(connection, p)

    def entropy_bounds(self, a: float | None = None, proof: str | None = None) -> Enclosure | None:
        """Return the closest proved bounds that are stored on the topological entropy at one a.

        None if there are none: `orbitdb bounds` finds and stores them.

        Parameters
        ----------
        a : float, optional
            The stadium; by default the catalogue's.
        proof : str, optional
            ``doubles`` or ``balls``: only bounds that rest on that; by default the closer ones.

        Raises
        ------
        InputError
            If `proof` is another word.
        """
        with self.reading() as connection:
            found = enclosures.closest(connection, proof, self.a if a is None else Stadium(a).a)
        return found[0] if found else None

    def entropy_curve(self, proof: str | None = None) -> list[Enclosure]:
        """Return the closest stored bounds on the topological entropy at every a, in order.

        The parameter is that of `entropy_bounds`.
        """
        with self.reading() as connection:
            return enclosures.closest(connection, proof)

    def sweeps(self, a: float) -> list[Sweep]:
        """Return what sweeps have counted and added up at one a, by period."""
        with self.reading() as connection:
            return sweeps.sweeps(connection, a)

    def counts(self, selection: Selection | None = None, **criteria: Any) -> Counted:
        """Return the counts of the paper's Table 1 at any a: from a fill, a sweep, or births.

        Parameters
        ----------
        selection : Selection, optional
            Its a and its periods count, all that are there by default; or name them by the criteria.
        **criteria
            As in `select`.
        """
        chosen = self._chosen(selection, criteria)
        with self.at_one_moment() as still, still.reading() as connection:
            return count(connection, still.fills(chosen.a), chosen)

    def __contains__(self, word: object) -> bool:
        """Tell whether what becomes of a word is stored, in any rotation and with any status."""
        try:
            return isinstance(word, str) and self._get(parse(word)) is not None
        except WordError:
            return False

    def __getitem__(self, word: str) -> Orbit:
        """Return the stored orbit of a word (run notation, too) in the rotation asked for.

        Raises
        ------
        KeyError
            If it is not stored; `orbitdb.solve_word` solves any word.
        WordError
            If it is no word.
        TypeError
            If it is no text.
        """
        symbols = parse(word)
        found = self._get(symbols)
        if found is None and not is_primitive(symbols):
            raise KeyError(f"{word} repeats {primitive_root(symbols)}: ask for that")
        if found is None:
            raise KeyError(f"{word} is not stored at a = {self.a:g}")
        return found

    def _get(self, word: str) -> Orbit | None:
        return self.find(word, self.a) if is_primitive(word) else None

    def __iter__(self) -> Iterator[str]:
        """Yield the stored words by period, as least rotations."""
        return (word for (word,) in self.rows(Selection(self.a, statuses=_SOLVED), ("code",)))

    def __len__(self) -> int:
        """Return how many words it holds; those that are geometrically pruned are not among them."""
        return self.count(Selection(self.a, statuses=_SOLVED))

    def __bool__(self) -> bool:
        return True

    def select(
        self,
        selection: Selection | None = None,
        *,
        order: str = "p,code",
        coordinates: bool = False,
        **criteria: Any,
    ) -> "Subset":
        """Return a chosen subset as arrays, one entry a symbol sequence.

        Parameters
        ----------
        selection : Selection, optional
            The subset; or name it by the criteria.
        order : str, optional
            Columns to sort by, as in `rows`.
        coordinates : bool, optional
            Whether to read the coordinates, too.
        **criteria
            As in `orbitdb.store.asking.selection.choose`, at the catalogue's a unless ``a`` is given.

        Examples
        --------
        >>> catalogue.select(p=(2, 11), status="orbit", length=(None, 9)).words  # doctest: +SKIP
        """
        from orbitdb.store.reading.subset import read_subset

        return read_subset(self, self._chosen(selection, criteria), order, coordinates)

    def classes(self, selection: Selection | None = None, **criteria: Any) -> "ChosenClasses":
        """Return the symmetry classes of a chosen subset, with how many of their words are in it.

        Only classes with a length and lambda, which are orbits and, if their status is named, orbits
        through a joint. No coordinates are read; unless the subset depends on the single words
        (``contains``, ``where``) they are not read either. The parameters are those of `select`.

        Raises
        ------
        SelectionError
            If a status is named whose sequences have no length and lambda.
        """
        from orbitdb.store.reading.chosen_classes import read_classes

        chosen = self._chosen(selection, criteria)
        return read_classes(self, chosen if chosen.statuses else replace(chosen, statuses=(Status.ORBIT,)))

    def _chosen(self, selection: Selection | None, criteria: dict[str, Any]) -> Selection:
        if selection is not None and criteria:
            raise SelectionError("give a Selection or criteria, not both")
        if not isinstance(selection, Selection | None):
            raise TypeError(f"name a subset by criteria such as p=3 or a Selection, not by {selection!r:.40}")
        if selection is not None:
            return selection
        return choose(**criteria) if "a" in criteria else choose(self.a, **criteria)

    def count(self, selection: Selection | None = None, **criteria: Any) -> int:
        """Return the number of rows in a chosen subset; the parameters are those of `select`."""
        chosen = self._chosen(selection, criteria)
        with self.reading() as connection:
            return count_rows(connection, chosen)
