"""Figures by their names: what `Catalogue.plot` returns, and `orbitdb plot` writes to a file."""

from collections.abc import Callable, Iterable, Mapping, Sequence, Sized
from typing import TYPE_CHECKING, Any, NamedTuple

from orbitdb.answers.level_lists import levels_by_parity
from orbitdb.billiard import USUAL_A
from orbitdb.criteria import Criteria
from orbitdb.errors import InputError, as_floats, as_texts, check_text
from orbitdb.output_files import FIGURES as FILES
from orbitdb.plots.registry import (
    FIGURES,
    LEAST_INCHES,
    MOST_INCHES,
    SIZES,
    SUBSET,
    Figure,
    load_function,
    whole_figure,
)
from orbitdb.plots.style import Picture, Size, entitle, short, sized
from orbitdb.quantum.waves import nearest_wave
from orbitdb.quantum.weyl import one_parity
from orbitdb.selection import Selection
from orbitdb.symbols.words import read_words
from orbitdb.text import format_float

if TYPE_CHECKING:
    from orbitdb.catalogue import Catalogue
    from orbitdb.orbits.orbit import Orbit

_MOST_K = 200.0
"""Largest k of a wave to draw."""


class _Asked(NamedTuple):
    """What is to be drawn: a figure of some words, or of subsets of a catalogue, one at each a."""

    catalogue: "Catalogue"
    figure: Figure
    codes: list[str]
    chosen: tuple[Selection, ...]
    values: Mapping[str, Any]

    @property
    def a(self) -> float:
        """Half length of the stadium to draw."""
        return self.chosen[0].a

    def draw(self, *what: Any, **more: Any) -> Picture:
        """Draw the figure, passing on the given values that it uses."""
        values = {**self.values, **more}
        used = {name: values[name] for name in self.figure.passes if values.get(name) is not None}
        made: Picture = load_function(self.figure.whole)(*what, **used)
        return made


def plot(
    catalogue: "Catalogue",
    name: str,
    selection: Selection | Sequence[Selection] | str | None,
    criteria: Criteria,
    values: Mapping[str, Any],
    size: Any = None,
    title: str | None = None,
) -> Picture:
    """Draw a figure (`Catalogue.plot`); `values` are its other arguments, None or False if not given."""
    if isinstance(selection, str):
        selection, criteria = None, {**criteria, "code": selection}
    given = [each for each, value in {**values, **criteria}.items() if _is_given(value)]
    if str(name).endswith(tuple(f".{ending}" for ending in FILES)):
        raise InputError(f"figure {name!r:.40}: name a figure, such as 'lengths', and write it with savefig")
    figure = whole_figure(name, given)
    _refuse_others(figure, given)
    with sized(_inches(size)):
        named = criteria.copy()
        codes = read_words(as_texts("code", named.pop("code", None) or []))
        a = named.get("a")
        chosen, on_a = _chosen(catalogue, figure, selection, named)
        grid = () if a is None or isinstance(a, str) else [*a] if isinstance(a, Iterable) else [a]
        known = {**values, "grid": grid, "opening": chosen[0].opening}
        made = _DRAW[figure.source](_Asked(catalogue, figure, codes, chosen, known))
    made.notes = (*on_a, *made.notes)
    if title is not None:
        check_text("title", title, "my orbits")
        entitle(made, title)
    return made


def _is_given(value: Any) -> bool:
    return not (value is None or value is False or (isinstance(value, Sized) and not len(value)))


def _refuse_others(figure: Figure, given: Sequence[str]) -> None:
    """Raise if an argument is given that the figure does not use."""
    used = {"code"} if "words" in figure.takes else set()
    for name in figure.takes:
        used |= {*Criteria.__annotations__} - {"code"} if name == SUBSET else {name}
    if idle := [name for name in given if name not in used]:
        raise InputError(f"plot {figure.name} does not use {', '.join(idle)}: leave out what it does not use")


def _inches(size: Any) -> Size | None:
    """Return the width and, if it is given, the height of a figure."""
    if size is None:
        return None
    told = f"size {size!r:.40}: give {SIZES}"
    given = as_floats(size, told).ravel().tolist()
    if len(given) not in (1, 2) or not all(LEAST_INCHES <= inches <= MOST_INCHES for inches in given):
        raise InputError(told)
    return given[0], given[1] if len(given) == 2 else None


def _chosen(
    catalogue: "Catalogue",
    figure: Figure,
    selection: Selection | Sequence[Selection] | None,
    criteria: Criteria,
) -> tuple[tuple[Selection, ...], tuple[str, ...]]:
    """Return the subset at each a, with the statuses that the figure shows by default, and a note on a."""
    if selection is None:
        criteria = criteria.copy()
        if criteria.get("status") is None:
            criteria["status"] = figure.status
        if "a" not in figure.takes or "grid" in figure.passes:
            criteria["a"] = USUAL_A  # what is drawn does not depend on it
    with catalogue._reading() as connection:
        chosen = catalogue._several(selection, criteria, connection)
        on_a = catalogue._on_a(criteria.get("a") if selection is None else 0.0, connection)
    if len(chosen) > 1 and not figure.several_a:
        *others, last = (each.name for each in FIGURES if each.several_a and not each.when)
        raise InputError(
            f"several a: plot {figure.name} draws one a; {', '.join(others)} and {last} draw several"
        )
    return chosen, on_a


def _of_catalogue(asked: _Asked) -> Picture:
    """Draw what a catalogue contains: chosen subsets, or its levels."""
    values, more = asked.values, dict[str, Any]()
    if "parts" in asked.figure.passes:
        with asked.catalogue._reading() as connection:
            given = values["levels"], values["parity"], bool(values["window"])
            more["parts"] = levels_by_parity(connection, asked.a, *given)
    elif "parity" in asked.figure.passes:
        more["parity"] = one_parity(values["parity"])
    return asked.draw(asked.catalogue, *asked.chosen, **more)


def _of_opening(asked: _Asked) -> Picture:
    """Draw what escapes from an open stadium, as it is stored or computed on the spot."""
    (chosen,) = asked.chosen
    ways = chosen.opening, chosen.without
    return asked.draw(asked.catalogue.escape(*ways, a=asked.a, jobs=None, store=False))


def _of_wave(asked: _Asked) -> Picture:
    """Draw the wave of the level nearest to k; if a code is given, draw its orbit on top."""
    k, parity = asked.values["k"], one_parity(asked.values["parity"])
    if not isinstance(k, int | float) or not 0 < k < _MOST_K:
        raise InputError(f"name the level by its k, above 0 and below {_MOST_K:g}, such as `k=20.17`")
    if parity is None:
        raise InputError("name one parity, such as `parity='ee'`")
    if len(asked.codes) > 1:
        raise InputError("name one orbit at most")
    orbits, notes = _orbits(asked)
    made = asked.draw(nearest_wave(asked.a, k, parity), next(iter(orbits), None))
    made.notes += notes
    return made


def _of_word(asked: _Asked) -> Picture:
    """Draw a word that need not be an orbit without a field."""
    kappa = asked.values["kappa"]
    curvatures = None if kappa is None else as_floats(kappa, "kappa: give one number or several").ravel()
    return asked.draw(_only(asked), asked.a, kappa=None if curvatures is None else curvatures.tolist())


def _of_orbit(asked: _Asked) -> Picture:
    """Draw a single orbit, read or solved."""
    word = _only(asked)
    if "a" not in asked.figure.takes:
        return asked.draw(asked.catalogue.orbit(word, a=asked.a))
    orbits, _ = _orbits(asked)
    return asked.draw(*orbits)


def _of_orbits(asked: _Asked) -> Picture:
    """Draw the orbits of several words on a sheet."""
    orbits, notes = _orbits(asked)
    made = asked.draw(orbits)
    made.notes += notes
    return made


def _only(asked: _Asked) -> str:
    """Return the only word."""
    if len(asked.codes) != 1:
        raise InputError(f"plot {asked.figure.name} draws one word: give it as `code='1232131'`")
    return asked.codes[0]


def _orbits(asked: _Asked) -> "tuple[list[Orbit], tuple[str, ...]]":
    """Return the orbits that have a path, and notes on the words without one; raise if no word has one."""
    orbits = asked.catalogue.orbit(asked.codes, a=asked.a)
    drawn = [orbit for orbit in orbits if orbit.points is not None]
    notes = tuple(
        f"{short(orbit.code)} at a = {format_float(asked.a)} cannot be drawn: {orbit.status.sentence}"
        for orbit in orbits
        if orbit.points is None
    )
    if notes and not drawn:
        raise InputError(notes[0])
    return drawn, notes


_DRAW: dict[str, Callable[[_Asked], Picture]] = {
    "orbit": _of_orbit,
    "orbits": _of_orbits,
    "word": _of_word,
    "wave": _of_wave,
    "opening": _of_opening,
    "catalogue": _of_catalogue,
}
"""The function for each source of a figure in the registry."""
