"""`StoredCatalogue`, the part of `Catalogue` that opens its file and lists what it contains."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from sqlalchemy import Connection

from orbitdb.answers.completeness import describe_fills
from orbitdb.billiard.stadium import Stadium
from orbitdb.errors import InputError, StoreError, checked_methods
from orbitdb.extras import Rows
from orbitdb.store.file import Store
from orbitdb.store.fills import read_fills, read_sweeps
from orbitdb.store.lives import read_birth_fills, read_lives
from orbitdb.store.lookup import WITH_ORBITS, a_meant, a_values, meant
from orbitdb.store.paths import default_path, home_expanded
from orbitdb.store.results import best_reference, bounds_by_a, tightest_bounds
from orbitdb.store.selection import Criteria, Selection, SelectionError, chosen_by, fillable

if TYPE_CHECKING:
    import sqlalchemy

    from orbitdb.answers.results import Births
    from orbitdb.entropy.bounds import EntropyBounds
    from orbitdb.store.contents import Contents
    from orbitdb.store.fills import Fill, Sweep
    from orbitdb.store.lives import BirthFill
    from orbitdb.trajectories.ensemble import Reference

_Answer = TypeVar("_Answer")

_SHOWN = 4
"""Maximum number of further values of ``a`` in a repr."""


@checked_methods
class StoredCatalogue:
    """A file of periodic orbits, and what it contains (`orbitdb.Catalogue`)."""

    def __init__(self, path: Path | str | None = None, a: float | None = None) -> None:
        self._a = None if a is None else Stadium(a).a
        self._file = Store(path)

    @classmethod
    def create(cls, path: Path | str | None = None, a: float | None = None) -> Self:
        """Open a catalogue; create a missing one first, and upgrade an old one to the latest schema."""
        from orbitdb.store.file import migrate

        migrate(default_path() if path is None else home_expanded(path))
        return cls(path, a)

    @property
    def path(self) -> Path:
        """Absolute path of the file."""
        return self._file.path

    @property
    def a(self) -> float:
        """Half length of the default stadium; it does not change once it has been determined.

        Raises
        ------
        InputError
            If you gave none, and orbits are stored at several values of ``a`` but not at 1.6.
        """
        if self._a is None:
            with self._file.snapshot() as moment:
                self._a = a_meant(moment)
        return self._a

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; a further question opens it again."""
        self._file.close()

    @property
    def engine(self) -> "sqlalchemy.Engine":
        """SQLAlchemy's engine for SQL of your own, such as ``pandas.read_sql(query, catalogue.engine)``.

        Its connections read the tables and views of `orbitdb sql`, and know ``code()``; they cannot write.
        """
        return self._file.engine

    def __reduce__(self) -> tuple[type[Self], tuple[Path, float | None]]:
        """Pickle only the path and ``a``; the copy opens the file itself."""
        return type(self), (self.path, self._a)

    def __repr__(self) -> str:
        try:
            with self._file.snapshot() as moment:
                contents = self._contents(moment)
        except StoreError as error:
            contents = str(error)
        return f"<Catalogue {self.path.name}: {contents}>"

    def _contents(self, moment: Connection) -> str:
        """Return one line that says which periods are filled, beginning with the default ``a``."""
        values = a_values(moment, WITH_ORBITS)
        try:
            own = [meant(values) if self._a is None else self._a]
        except InputError:
            own = []
        others = [a for a in values if a not in own]
        parts = [describe_fills(read_fills(moment, a), a) for a in (*own, *others[:_SHOWN])]
        return "; ".join(parts) + (f"; and at {len(others) - _SHOWN} more" if len(others) > _SHOWN else "")

    # what is stored

    def a_values(self, *, orbits: bool = False) -> list[float]:
        """Return the stored values of ``a`` in order; with `orbits`, only those with orbits or sweeps."""
        with self._file.snapshot() as moment:
            return a_values(moment, WITH_ORBITS if orbits else ())

    def fills(self, *, a: float | None = None) -> "Rows[Fill]":
        """Return the fills at a given ``a``, in order of period."""
        with self._file.snapshot() as moment:
            return Rows(read_fills(moment, self._at(a)))

    def birth_fills(self) -> "Rows[BirthFill]":
        """Return how far births and deaths are stored, period by period."""
        with self._file.snapshot() as moment:
            return Rows(read_birth_fills(moment))

    def births(self, p: int) -> "Births":
        """Return the ranges of ``a`` in which the classes of a period are orbits, in order of birth.

        The list is empty if no births of the period are stored (`fill_births`).

        Raises
        ------
        InputError
            If no catalogue can have births of the period.
        """
        from orbitdb.answers.results import Births

        fillable([(p, p)])
        with self._file.snapshot() as moment:
            return Births(read_lives(moment, p))

    def entropy_bounds(self, *, a: float | None = None, proof: str | None = None) -> "EntropyBounds | None":
        """Return the tightest bounds on the topological entropy that `prove_bounds` stored, or None.

        Parameters
        ----------
        proof : str, optional
            ``doubles`` or ``balls``, for bounds proved in this arithmetic only; by default in either.
        """
        with self._file.snapshot() as moment:
            return tightest_bounds(moment, self._at(a), proof)

    def entropy_curve(self, *, proof: str | None = None) -> "Rows[EntropyBounds]":
        """Return the tightest stored bounds on the topological entropy at every ``a`` that has any."""
        with self._file.snapshot() as moment:
            return Rows(bounds_by_a(moment, proof))

    def reference(self, *, a: float | None = None) -> "Reference | None":
        """Return the averages over trajectories, with the smallest error, that `simulate` stored, or None."""
        with self._file.snapshot() as moment:
            return best_reference(moment, self._at(a))

    def sweeps(self, *, a: float | None = None) -> "Rows[Sweep]":
        """Return the sweeps at a given ``a``, with their counts and sums, in order of period."""
        with self._file.snapshot() as moment:
            return Rows(read_sweeps(moment, self._at(a)))

    def contents(self, a: float, p: int | str | Iterable[int] | None = None) -> "Contents":
        """Return what is stored at a given ``a``, in some periods or in all; `delete` would delete it."""
        from orbitdb.store.contents import contents

        chosen = chosen_by(a=a, p=p)
        with self._file.snapshot() as moment:
            return contents(moment, chosen.a, chosen.periods)

    def _answer(
        self,
        function: Callable[..., _Answer],
        selection: Selection | None,
        criteria: Criteria,
        *arguments: Any,
    ) -> _Answer:
        """Call a function with a moment of the file, the chosen subset and further arguments."""
        chosen = self._chosen(selection, criteria)
        with self._file.snapshot() as moment:
            return function(moment, chosen, *arguments)

    def _chosen(self, selection: Selection | None, criteria: Criteria) -> Selection:
        if selection is not None and criteria:
            raise SelectionError("give a Selection or criteria, not both")
        if not isinstance(selection, Selection | None):
            raise SelectionError(
                f"choose a subset by criteria such as p=3 or a Selection, not {selection!r:.30}"
            )
        if selection is not None:
            return selection
        named = criteria.copy()
        if named.get("a") is None:
            named["a"] = self.a
        return chosen_by(**named)

    def _at(self, a: float | None) -> float:
        return self.a if a is None else Stadium(a).a
