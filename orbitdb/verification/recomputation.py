"""Check stored orbits against new solutions: in double precision, from random starts, and in ball arithmetic.

A row that is proved in ball arithmetic gets a certificate.
"""

from collections.abc import Generator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb import __version__
from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.stadium import Stadium
from orbitdb.numerals import exact
from orbitdb.orbits.newton import certificates
from orbitdb.orbits.status import EXISTING, NUMBERS, Orbits, Status
from orbitdb.store.asking.selection import Selection
from orbitdb.store.file.tables import certificate
from orbitdb.store.reading.audit import (
    StoredBlock,
    ids_in,
    load_orbits,
    sampled_classes,
    stadium_id,
    whole_rows,
)
from orbitdb.store.reading.moment import Reader
from orbitdb.store.writing.writer import Writer, replace_certificates
from orbitdb.symbols.words import to_strings
from orbitdb.verification.check import Check, Checked, blocks, judged, measured
from orbitdb.verification.invariants import rounding_of_places, with_bounds

if TYPE_CHECKING:
    from orbitdb.orbits.balls import Enclosure
from collections.abc import Iterator

from orbitdb.billiard.legs import Legs, cut, derivatives, direction_limits
from orbitdb.orbits.error_bounds import direction_errors
from orbitdb.orbits.newton import newton
from orbitdb.verification.check import shares

BOUNDED = {"coordinates": "error", "length": "length_error", "lyapunov": "lyapunov_error"}

_SETTLED = 1e-6


def check_against(stored: Orbits, fresh: Orbits) -> Iterator[Check]:
    """Check stored orbits against new solutions: statuses must agree, and numbers agree within the bounds.

    Every row must already have the values that its status demands.
    """
    labels = to_strings(stored.words)
    sign = np.where(stored.status == Status.DYNAMICAL.value, -1.0, 1.0)
    wrong_side = (stored.status != Status.BOUNDARY.value) & (sign * stored.margin < 0)
    yield judged("statuses", labels, (stored.status != fresh.status) | wrong_side)
    yield judged("unresolved", labels, stored.status == Status.UNRESOLVED.value)

    both = np.flatnonzero(np.isin(stored.status, EXISTING) & np.isin(fresh.status, EXISTING))
    kept, found = stored.rows(both), fresh.rows(both)
    deviation, allowed = [], []
    for name, bound in BOUNDED.items():
        distance = np.abs(getattr(kept, name) - getattr(found, name))
        deviation.append(distance.max(axis=1) if distance.ndim == 2 else distance)
        allowed.append(getattr(kept, bound) + getattr(found, bound))
    yield _worst("bounds", [labels[row] for row in both], np.stack(deviation), np.stack(allowed))


def _worst(name: str, labels: Sequence[str], deviation: Floats, allowed: Floats) -> Check:
    """Check the worst of k deviations of each row; the arrays have shape (k, N)."""
    worst = shares(deviation, allowed).argmax(axis=0), np.arange(len(labels))
    return measured(name, labels, deviation[worst], allowed[worst])


def check_bits(stored: Orbits, fresh: Orbits) -> Check:
    """Check that a new solution gives the same bits, as it must with the same version and `arithmetic`."""
    labels = to_strings(stored.words)
    kept = np.isin(fresh.status, EXISTING)
    differs = stored.iterations != fresh.iterations
    for name in NUMBERS:
        value = getattr(fresh, name)
        expected = np.where((kept | (name == "margin")) & np.isfinite(value), value, np.nan)
        differs |= _bits_differ(getattr(stored, name), expected + 0.0)  # SQLite stores -0.0 as 0.0
    places = np.where(kept[:, None], fresh.coordinates, np.nan)
    differs |= _bits_differ(stored.coordinates, places).any(axis=1)
    return judged("bits", labels, differs)


def _bits_differ(x: Floats, y: Floats) -> Marks:
    differ: Marks = x.view(np.int64) != y.view(np.int64)
    return differ & ~(np.isnan(x) & np.isnan(y))


def restart(words: NDArray[np.uint8], stadium: Stadium, times: int, rng: np.random.Generator) -> Check:
    """Solve admissible words, shape (N, p), again from random directions within their limits, and compare.

    The rows of the check are the restarts that converged. The deviation is the largest difference of a
    direction, in radians; it must not exceed the sum of both error bounds.
    """
    found = Check("restarts", 0)
    text = to_strings(words)
    for rows, legs in cut(words):
        labels = [text[row] for row in rows]
        first = newton(legs, stadium.a).alpha
        first_error = _errors(legs, stadium.a, first)
        low, high = direction_limits(legs, stadium.a)
        for _ in range(times):
            again = newton(legs, stadium.a, start=rng.uniform(low, high)).alpha
            error = _errors(legs, stadium.a, again)
            rest = np.flatnonzero(error.max(axis=0) < _SETTLED)
            apart, allowed = np.abs(again - first)[:, rest], (error + first_error)[:, rest]
            found = found.joined(_worst("restarts", [labels[row] for row in rest], apart, allowed))
    return found


def _errors(legs: Legs, a: float, alpha: Floats) -> Floats:
    slopes = derivatives(legs, a, alpha)
    return direction_errors(legs, a, alpha, slopes)


_BATCH = 256
_SHARP = 512
"""Precision in bits for rows whose bounds came from balls of the usual precision, which cannot prove them."""


def certify(
    path: Path, selection: Selection, sample: int | None = None, seed: int = 0, again: bool = False
) -> Generator[Checked]:
    """Prove the rows of the chosen classes in ball arithmetic, and store the certificates.

    Each batch is stored in one transaction; after an interruption, the next run continues from there.

    Parameters
    ----------
    path : Path
    selection : Selection
    sample, seed : int, optional
        As in `orbitdb.verification.verify.verify`.
    again : bool, optional
        Also prove rows that already have a certificate.

    Yields
    ------
    Checked
        After every stored batch.
    """
    source = Reader(path)
    with source.moment() as moment:
        connection = moment.connection
        chosen = sampled_classes(connection, selection, sample, np.random.default_rng(seed))
        number = stadium_id(connection, selection.a)
        if number is None:
            return
        proofs = ids_in(connection, certificate.c.cycle, certificate.c.stadium == number)
    known = proofs[:0] if again else proofs
    todo = {p: np.setdiff1d(those, known) for p, those in chosen.items()}
    with closing(Writer(source.path, {"command": "verify --rigorous", "a": selection.a})) as writer:
        for block in blocks(todo, _BATCH):
            with source.moment() as moment:
                stored = load_orbits(moment.connection, number, block.ids)
            check, proved = _prove_block(stored, block.p, Stadium(selection.a))
            with writer.writing() as connection:
                ids = block.ids.tolist()
                replace_certificates(writer, connection, number, ids, proved, __version__)
            check = replace(check, first=check.first and f"{check.first} at a = {exact(selection.a)}")
            yield Checked(
                f"proofs at a = {exact(selection.a)}, p = {block.p}", block.done, block.total, (check,)
            )


def _prove_block(stored: StoredBlock, p: int, stadium: Stadium) -> tuple[Check, list[tuple[int, float, int]]]:
    """Prove rows of one period; return the check, and the id, radius and precision of each proved row."""
    rows = whole_rows(stored, p, stored.whole(p))
    rest = set(range(len(stored.words))) - set(rows)
    check = judged("certificates", [stored.words[i] for i in sorted(rest)], [True] * len(rest))
    if not rows:
        return check, []
    found, proved, radius, bits = prove(with_bounds(stored.orbits(rows), stadium), stadium)
    entries = zip(rows, radius.tolist(), bits, proved.tolist(), strict=True)
    return found.joined(check), [(stored.columns["cycle"][i], *rest) for i, *rest, ok in entries if ok]


def prove(stored: Orbits, stadium: Stadium) -> tuple[Check, Marks, Floats, Sequence[int]]:
    """Prove N stored rows, which must have the values that their status demands, in ball arithmetic.

    A row is proved if its status is that of the enclosure and, for an orbit, all coordinates, the length,
    lambda and the margin differ from the true values by no more than the row's bounds.

    Returns
    -------
    check : Check
        A row's deviation is that of the coordinates, length, lambda or margin with the largest share.
    proved : ndarray of bool, shape (N,)
    radius : ndarray, shape (N,)
        Proved distance of the stored coordinates from the true ones; 0 without coordinates.
    bits : sequence of int
        Precision of each proof.
    """
    labels = to_strings(stored.words)
    enclosed = certificates(stored.words, stadium)
    distances = np.array([_distances(stored, row, ball, stadium) for row, ball in enumerate(enclosed)])
    doubtful = np.flatnonzero(~(distances[:, 1] <= distances[:, 2]))
    sharper = certificates(stored.words[doubtful], stadium, _SHARP) if len(doubtful) else []
    for row, ball in zip(doubtful.tolist(), sharper, strict=True):
        enclosed[row], distances[row] = ball, _distances(stored, row, ball, stadium)
    radius, deviation, allowed = distances.T
    check = measured("certificates", labels, deviation, allowed)
    return check, deviation <= allowed, radius, [ball.precision for ball in enclosed]


def _distances(stored: Orbits, row: int, ball: "Enclosure", stadium: Stadium) -> tuple[float, float, float]:
    """Return the largest distance of a coordinate from its ball, and the worst distance with its bound.

    The worst distance has the largest share of its bound, and is infinite if the status is wrong.
    """
    from orbitdb.orbits.balls import distance

    if ball.status.value != stored.status[row] or ball.status is Status.UNRESOLVED:
        return 0.0, np.inf, 1.0
    if ball.status.value not in EXISTING:
        return 0.0, 0.0, 1.0
    numbers = {name: float(getattr(stored, name)[row]) for name in NUMBERS}
    places = zip(ball.coordinates, stored.coordinates[row].tolist(), strict=True)
    radius = max(distance(*place) for place in places)
    pairs = (
        (radius, numbers["error"]),
        (distance(ball.length, numbers["length"]), numbers["length_error"]),
        (distance(ball.lyapunov, numbers["lyapunov"]), numbers["lyapunov_error"]),
        (distance(ball.margin, numbers["margin"]), numbers["error"] + rounding_of_places(stadium)),
    )
    return radius, *max(pairs, key=lambda pair: pair[0] / pair[1] if pair[1] > 0 else np.inf)
