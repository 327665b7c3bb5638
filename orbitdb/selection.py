"""`Selection`, a chosen subset of the words of a catalogue, and its description in words."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Unpack

from orbitdb.billiard import USUAL_A
from orbitdb.billiard.stadium import Stadium
from orbitdb.criteria import (
    MEASURES,
    MOST_CODES,
    OF_STATUS,
    Criteria,
    Limits,
    each_of,
    pair_of,
    parse_statuses,
    parse_symmetry,
)
from orbitdb.errors import SelectionError
from orbitdb.open_stadium.openings import Opening, parse_openings, spans_on
from orbitdb.orbits.status import STORED, Status
from orbitdb.period_ranges import listed, parse_periods
from orbitdb.sql_text import names_in, plain_values
from orbitdb.symbols.pruning import rules_of
from orbitdb.symbols.words import least_rotation, parse, parse_primitive
from orbitdb.text import format_float, guess, printable, several, shortened

_MOST_VALUES = 6


@dataclass(frozen=True)
class Selection:
    """A chosen subset of the words of a catalogue.

    Methods of `Catalogue` that answer for a subset take a Selection or, as arguments, the criteria that
    `from_criteria` explains, such as ``p="2-8", status="orbit", lambda_c=(None, 0.4)``.

    Attributes
    ----------
    a : float
        Half length of the stadium.
    periods : tuple of (int, int)
        Ranges of periods, including both ends; empty for all periods.
    statuses : tuple of Status
        The statuses that a word may have; empty for all.
    time_reversal : str or None
        ``self`` or ``pair``.
    symmetry : str or None
        The exact symmetry label, such as ``x,T,xT``.
    codes : tuple of str
        Words, as least rotations; empty for all.
    contains : str or None
        Consecutive symbols of the word, read cyclically.
    without : tuple of str
        Patterns of consecutive symbols that the word must not contain, read cyclically.
    opening : tuple of Opening
        Intervals of the boundary in which the word must not have a bounce; words that are no orbits have none
        at all, and are left out.
    exists, not_at : tuple of float
        Values of a at which the word must be an orbit, and at which it must not be, judged by its births.
    ranges : mapping of str to (float or None, float or None)
        Least and greatest values of some `MEASURES`, both inclusive; None for no limit.
    where : str or None
        An SQL expression that uses the columns of the view ``catalogue``.
    parameters : mapping of str to value
        Values for the names (``:name``) in ``where``.
    """

    a: float = USUAL_A
    periods: tuple[tuple[int, int], ...] = ()
    statuses: tuple[Status, ...] = ()
    time_reversal: str | None = None
    symmetry: str | None = None
    codes: tuple[str, ...] = ()
    contains: str | None = None
    without: tuple[str, ...] = ()
    opening: tuple[Opening, ...] = ()
    exists: tuple[float, ...] = ()
    not_at: tuple[float, ...] = ()
    ranges: Mapping[str, Limits] = field(default_factory=dict, hash=False)
    where: str | None = None
    parameters: Mapping[str, str | int | float] = field(default_factory=dict, hash=False)

    @classmethod
    def from_criteria(cls, **criteria: "Unpack[Criteria]") -> "Selection":
        """Return the selection that fulfils all of the given criteria.

        Parameters
        ----------
        a : float, optional
            Half length of the stadium; by default the catalogue's, or 1.6.
        p : int, str or iterable of int, optional
            A period, several periods such as ``range(2, 6)``, or a text such as ``2,3,5-7``.
        status : Status, str or iterable of them, optional
            One or more statuses; a text such as ``orbit,boundary`` can name several, and ``all`` means every
            one. By default orbits; but every status if words are named (`code`), if `exists`, `not_at`,
            `born` or `dies` ask for lives, or if `where` names a column of these or of the status.
        time_reversal : str, optional
            ``self`` for orbits that retrace their path, ``pair`` for the others.
        symmetry : str, optional
            The exact symmetry, such as ``x,T,xT``; ``1`` for none.
        code : str or iterable of str, optional
            Words, in any rotation.
        contains : str, optional
            Consecutive symbols that the words must contain, read cyclically, such as ``"0202"``.
        without : str or iterable of str, optional
            Patterns of symbols that the words must not contain, read cyclically.
        opening : str or iterable of str, optional
            Intervals of the boundary in which the words must not have a bounce, such as ``"top:-0.3:0.3"``.
        exists, not_at : float or iterable of float, optional
            Values of ``a`` at which the words must be orbits, and at which they must not be.
        where : str, optional
            An SQL expression that uses the columns of the view ``catalogue``.
        parameters : mapping, optional
            Values for the names (``:name``) in `where`.
        length, quarter_length, lyapunov, quarter_lyapunov, lambda_d, lambda_c, margin, born, dies : optional
            Pairs of the least and the greatest value, or None for no limit, as in ``length=(3, None)``.
        walls : int or (int, int), optional
            Number of bounces on straight walls, or its least and greatest value.

        Raises
        ------
        SelectionError
            If a criterion is invalid.
        """
        if unknown := sorted(set(criteria) - set(Criteria.__annotations__)):
            meant, names = guess(unknown[0], Criteria.__annotations__), ", ".join(Criteria.__annotations__)
            raise SelectionError(f"{', '.join(unknown)}: not a criterion; {meant}criteria are {names}")
        given: dict[str, Any] = {name: value for name, value in criteria.items() if value is not None}
        where, reversal = given.get("where"), given.get("time_reversal")
        if not isinstance(where, str | None):
            raise SelectionError(f"where {where!r:.40}: give an SQL expression such as 'lambda_c < 0.4'")
        parameters = plain_values(given.get("parameters", {}))
        if parameters and where is None:
            names = ", ".join(parameters)
            raise SelectionError(f"{names}: parameters are for names in where, which is not given")
        if reversal not in (None, *REVERSALS):
            raise SelectionError(f"reversal {reversal!r}: use self or pair")
        ranges = {name: pair_of(name, given[name]) for name in MEASURES if name in given}
        chosen = cls(
            a=Stadium(given.get("a", USUAL_A)).a,
            periods=parse_periods(listed(given["p"])) if "p" in given else (),
            statuses=parse_statuses(given.get("status", ())),
            time_reversal=reversal,
            symmetry=parse_symmetry(given["symmetry"]) if "symmetry" in given else None,
            codes=each_of(given, "code", _code, MOST_CODES),
            contains=parse(given["contains"]) if "contains" in given else None,
            without=each_of(given, "without", parse),
            opening=parse_openings(given.get("opening", ())),
            exists=each_of(given, "exists", _half_length),
            not_at=each_of(given, "not_at", _half_length),
            ranges={name: bounds for name, bounds in ranges.items() if bounds != (None, None)},
            where=where,
            parameters=parameters,
        )
        return chosen if "status" in given else replace(chosen, statuses=chosen.usual_statuses)

    @property
    def usual_statuses(self) -> tuple[Status, ...]:
        """The statuses that are chosen if none is named (`from_criteria`)."""
        if OF_STATUS & names_in(self.where or "") or any(map(rules_of, self.codes)):
            return STORED
        lives = self.exists or self.not_at or self.ranges.keys() & OF_STATUS
        return () if lives or self.codes else (Status.ORBIT,)

    def preferring(self, statuses: tuple[Status, ...]) -> "Selection":
        """Return the selection with these statuses in place of the usual ones; any others stay."""
        return replace(self, statuses=statuses) if self.statuses == self.usual_statuses else self

    def criteria(self) -> dict[str, Any]:
        """Return the criteria from which `from_criteria` makes this selection, except the usual ones."""
        spans = [str(low) if low == high else f"{low}-{high}" for low, high in self.periods]
        statuses = self.statuses or [status for status in STORED if status is not Status.GEOMETRIC]
        criteria = {
            "p": ",".join(spans),
            "status": "" if self.statuses == self.usual_statuses else ",".join(statuses),
            "code": list(self.codes),
            **{name: getattr(self, name) for name in ("time_reversal", "symmetry", "contains")},
            "without": list(self.without),
            "opening": list(map(str, self.opening)),
            "exists": list(self.exists),
            "not_at": list(self.not_at),
            **{name: tuple(bounds) for name, bounds in self.ranges.items()},
            "where": self.where,
            "parameters": dict(self.parameters),
        }
        return {"a": self.a, **{name: value for name, value in criteria.items() if value}}

    def check_opening(self) -> None:
        """Raise `OpeningError` if an opening does not fit on the boundary at this a."""
        spans_on(Stadium(self.a), self.opening)

    def includes(self, p: int) -> bool:
        """Tell whether the subset can contain words of a given period."""
        return not self.periods or any(low <= p <= high for low, high in self.periods)

    def describe(self, stadiums: Sequence[float] = (), count: int | None = None) -> str:
        """Describe the selection in one line, with the number of its words or several stadiums, if given."""
        one, many = self._subjects()
        parts = [many if count is None else several(count, one, many)]
        if self.periods:
            spans = [str(low) if low == high else f"{low} to {high}" for low, high in self.periods]
            parts.append(f"of period {', '.join(spans)}")
        parts.append(f"at a = {_listed_values(stadiums or (self.a,))}")
        if self.time_reversal:
            said = (_REVERSAL_OF_ONE if count == 1 else REVERSALS)[self.time_reversal]
            exist = self.statuses and {Status.ORBIT, Status.BOUNDARY}.issuperset(self.statuses)
            parts.append(said.format(another="orbit" if exist else "word"))
        return " ".join(filter(None, [*map(printable, parts), self.describe_rest(count)]))

    def describe_rest(self, count: int | None = None) -> str:
        """Describe all criteria except a, periods, statuses and time reversal; the text may be empty."""
        parts = []
        if self.symmetry:
            parts.append("without symmetry" if self.symmetry == "1" else f"with symmetry {self.symmetry}")
        if self.codes:
            named = f"with code {' or '.join(shortened(code, 60) for code in self.codes)}"
            parts.append(named if len(self.codes) <= _MOST_VALUES else f"of {len(self.codes)} codes")
        if self.contains:
            parts.append(f"containing {shortened(self.contains, 60)}")
        if self.without:
            parts.append(f"without {' or '.join(shortened(pattern, 60) for pattern in self.without)}")
        if self.opening:
            parts.append(f"without a bounce in {' or '.join(map(str, self.opening))}")
        if self.exists or self.not_at:
            lists = (("", self.exists), ("not " if self.exists else "", self.not_at))
            spans = [f"{no}at a = {', '.join(map(format_float, values))}" for no, values in lists if values]
            alive, dead = ("exists", "does not exist") if count == 1 else ("exist", "do not exist")
            parts.append(f"that {alive if self.exists else dead} {' and '.join(spans)}")
        bounded = (item for item in self.ranges.items() if item[1] != (None, None))
        parts += [f"with {_span(name, *bounds)}" for name, bounds in bounded]
        if self.where:
            values = ", ".join(f"{name} = {value!r}" for name, value in self.parameters.items())
            parts.append(f"where {self.where}" + (f" ({values})" if values else ""))
        return printable(" ".join(parts))

    def _subjects(self) -> tuple[str, str]:
        if not self.statuses or set(self.statuses) == set(STORED):
            return "word", "words"
        one, many = zip(*(_SUBJECTS[status] for status in self.statuses), strict=True)
        return " or ".join(one), " and ".join(many)


_SUBJECTS = {
    Status.ORBIT: ("orbit", "orbits"),
    Status.GEOMETRIC: ("geometrically pruned word", "geometrically pruned words"),
    Status.DYNAMICAL: ("dynamically pruned word", "dynamically pruned words"),
    Status.BOUNDARY: ("orbit through a joint", "orbits through a joint"),
    Status.FAMILY: ("bouncing-ball family", "bouncing-ball families"),
    Status.UNRESOLVED: ("unresolved word", "unresolved words"),
}
REVERSALS = {"self": "that retrace their path", "pair": "whose time reverse is another {another}"}
_REVERSAL_OF_ONE = REVERSALS | {"self": "that retraces its path"}


def _listed_values(values: Sequence[float]) -> str:
    shown = ", ".join(map(format_float, values[:_MOST_VALUES]))
    return shown + (f" and {len(values) - _MOST_VALUES} more" if len(values) > _MOST_VALUES else "")


def _span(name: str, low: float | None, high: float | None) -> str:
    if low is None:
        return f"{name} <= {'' if high is None else format_float(high)}"
    if low == high:
        return f"{name} = {format_float(low)}"
    if high is None:
        return f"{name} >= {format_float(low)}"
    return f"{format_float(low)} <= {name} <= {format_float(high)}"


def _code(word: str) -> str:
    return least_rotation(parse_primitive(word))


def _half_length(a: float) -> float:
    return Stadium(a).a
