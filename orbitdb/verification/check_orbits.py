"""Check each stored orbit: against a new solution, by plane geometry, from random starts, and with proof.

By plane geometry, every number is computed again from the coordinates, bounce by bounce, without runs and
legs. The allowed differences follow from the error bound of the row: each bounce is off its position on the
orbit by at most e, the sum of this bound and the rounding error of a position in the stadium. To first order,
this turns a link of length l by up to 2 e / l, and changes angles, length, monodromy matrix and Hessian
accordingly.

A row that is proved in ball arithmetic gets a certificate.
"""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from orbitdb import __version__
from orbitdb.arrays import Floats, Marks
from orbitdb.billiard.arithmetic import EPSILON
from orbitdb.billiard.legs import Derivatives, Legs, cut, derivatives, direction_limits
from orbitdb.billiard.stability import Links, couplings_of, exponent, hessian
from orbitdb.billiard.stadium import HALF_PI, STRAIGHT, Stadium
from orbitdb.orbits.admissible import certificates, solve_admissible
from orbitdb.orbits.error_bounds import direction_errors, enclosed_areas
from orbitdb.orbits.newton import newton
from orbitdb.orbits.orbits import Orbits
from orbitdb.orbits.status import EXISTING, Status
from orbitdb.selection import Selection
from orbitdb.store.file import Store
from orbitdb.store.storing import replace_certificates
from orbitdb.store.writer import Writer
from orbitdb.symbols.symmetry import class_of, encloses_nothing
from orbitdb.symbols.words import to_strings
from orbitdb.text import format_float
from orbitdb.verification.checks import LISTED, Check, Checked, Scope, blocks, shares, stored_orbits

if TYPE_CHECKING:
    from orbitdb.orbits.balls import Enclosure


MAX_DENSE = 512
"""Longest word whose p x p Hessian is checked."""

_VAGUE = 1e-2


def rounding_of_positions(stadium: Stadium) -> float:
    """Return how far rounding can move a position in the stadium, or the difference of two positions."""
    return 4 * EPSILON * (stadium.a + 2)


@dataclass(frozen=True)
class _Path:
    """Closed paths through the stored bounces, and their possible distance from the orbits.

    `sine` and `tilt`, shape (2, N, p), refer to the angles between the tangent and the incoming and outgoing
    path. `place` has shape (N, 1), the other arrays (N, p).
    """

    links: Links
    curved: Marks  # whether a bounce is on a semicircle
    place: Floats  # possible distance of a bounce from its position on the orbit, in any direction
    rounding: float  # the part of this distance beyond the error bound of the row
    sine: Floats
    tilt: Floats  # possible errors of these angles
    stretch: Floats  # possible error of the length of the link after each bounce

    @classmethod
    def of(cls, orbits: Orbits, stadium: Stadium) -> "_Path":
        links = Links.of(stadium, orbits.words, orbits.coordinates)
        curved = ~STRAIGHT[orbits.words]
        rounding = rounding_of_positions(stadium)
        place = (orbits.error + rounding)[:, None]
        cosine = np.stack([links.cos_in, links.cos_out])
        sine = np.sqrt(np.maximum(1 - cosine**2, EPSILON**2))
        turn = 2 * place / np.stack([links.before, links.after])
        tilt = turn + np.where(curved, place, 0.0) + 4 * EPSILON / sine
        return cls(links, curved, place, rounding, sine, tilt, 2 * place + 4 * EPSILON * links.after)

    def bend(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Return the entries of the Hessian and their possible errors, in five arrays.

        The diagonal is the sum of sin^2 / l over both links (first array), minus both sines for a bounce on a
        semicircle (fifth array). The couplings (second array) are sin sin' / l for an orbit; the program
        computes them as (cos cos' - t . t') / l, where t and t' are the tangents at the ends of a link. The
        third and fourth arrays are the errors of the diagonal and of the couplings.
        """
        path = np.stack([self.links.before, self.links.after])
        stretch = np.stack([_previous(self.stretch), self.stretch])
        own = self.sine**2 / path
        loose = (2 * self.sine * self.tilt + self.tilt**2) / path + own * stretch / path
        sines = np.where(self.curved, self.sine.sum(axis=0), 0.0)
        loose_sines = np.where(self.curved, self.tilt.sum(axis=0), 0.0)
        coupling = self.sine[1] * _next(self.sine[0]) / path[1]
        angles = self.sine[1] * self.tilt[1] + _next(self.sine[0] * self.tilt[0])
        tangents = 2 * self.place + 4 * EPSILON
        loose_coupling = (angles + tangents) / path[1] + coupling * self.stretch / path[1]
        return own.sum(axis=0), coupling, loose.sum(axis=0) + loose_sines, loose_coupling, sines


def _previous(values: Floats) -> Floats:
    return np.roll(values, 1, axis=1)


def _next(values: Floats) -> Floats:
    return np.roll(values, -1, axis=1)


def _finite(matrices: Floats) -> Floats:
    """Replace matrices that are not finite by zeros, shape (N, p, p); they arise when bounces coincide.

    The signs of their eigenvalues then count as undecided.
    """
    return np.where(np.isfinite(matrices).all(axis=(1, 2), keepdims=True), matrices, 0.0)


def with_bounds(orbits: Orbits, stadium: Stadium) -> Orbits:
    """Return the orbits, with error bounds added to those from the relaxation, which computes none.

    To first order, the coordinates are off by the inverse Hessian times the forces; the bound is twice that.
    Words longer than `MAX_DENSE` get no bounds.
    """
    p = orbits.words.shape[1]
    bare = np.flatnonzero(np.isnan(orbits.error) & np.isfinite(orbits.residual))
    if p > MAX_DENSE or not len(bare):
        return orbits
    part = orbits.rows(bare)
    size = np.abs(np.linalg.eigvalsh(_finite(hessian(stadium, part.words, part.coordinates))))
    rounding = rounding_of_positions(stadium)
    error = 2 * np.sqrt(p) * (part.residual + 2 * rounding) / size.min(axis=1)
    length_error = p * (size.max(axis=1) * error**2 + 2 * rounding)
    area_error = enclosed_areas(stadium, part.words, part.coordinates, error)[1]
    part = replace(part, error=error, length_error=length_error, area_error=area_error)
    part = replace(part, lyapunov_error=_exponents(part, _Path.of(part, stadium))[1])
    bounded = orbits.rows(np.arange(len(orbits)))  # a copy
    bounded.place(bare, part)
    return bounded


def check_consistency(orbits: Orbits, stadium: Stadium) -> Iterator[Check]:
    """Check walls, law of reflection, length, lambda and Hessian of N orbits of one period."""
    if not len(orbits):
        return
    labels = to_strings(orbits.words)
    path = _Path.of(orbits, stadium)
    yield _walls(orbits, stadium, path, labels)
    force = np.abs(path.links.cos_in - path.links.cos_out)
    yield Check.measured("reflection", labels, force.T, ((path.sine + path.tilt) * path.tilt).sum(axis=0).T)
    yield _length_and_area(orbits, stadium, path, labels)
    yield _lambda(orbits, path, labels)
    if orbits.words.shape[1] <= MAX_DENSE:
        yield _hessian(orbits, stadium, path, labels)


def _walls(orbits: Orbits, stadium: Stadium, path: _Path, labels: Sequence[str]) -> Check:
    """Check that bounces are on their walls, that runs keep their sense, and that margins are right."""
    words, x = orbits.words, orbits.coordinates
    ends = np.where(path.curved, HALF_PI, stadium.a)
    margin = (ends - np.abs(x)).min(axis=1)
    sense = np.where(words >= 4, -1.0, 1.0)
    backwards = np.where(words == np.roll(words, -1, axis=1), sense * (x - _next(x)), 0.0).max(axis=1)
    outside = np.where(orbits.status == Status.BOUNDARY.value, np.abs(margin), -margin)
    deviation = np.stack([outside.clip(0.0), backwards.clip(0.0), np.abs(orbits.margin - margin)])
    return Check.measured("walls", labels, deviation, path.place[:, 0])


def _length_and_area(orbits: Orbits, stadium: Stadium, path: _Path, labels: Sequence[str]) -> Check:
    """Check the stored length against the sum of the links, which is stationary at the orbit, and the area.

    The area is that of the triangles from the first bounce to each link. If each bounce moves by at most e,
    it changes by at most e times the length of the path, plus p e^2 / 2.
    """
    own, coupling, loose, loose_coupling, sines = path.bend()
    firm = own + sines + loose + 2 * (coupling + loose_coupling)
    second = orbits.error**2 * firm.sum(axis=1)
    rounding = (2 * path.rounding + 4 * EPSILON * path.links.after).sum(axis=1)
    total = path.links.after.sum(axis=1)
    points = stadium.points(orbits.words, orbits.coordinates)
    x, y = np.moveaxis(points - points[:, :1], -1, 0)
    area = (x * _next(y) - y * _next(x)).sum(axis=1) / 2
    place, p = path.place[:, 0], orbits.words.shape[1]
    moved = place * total + p * place**2 / 2 + p * EPSILON * (stadium.a + 1) * total
    deviation = np.stack([np.abs(orbits.length - total), np.abs(orbits.area - area)])
    allowed = np.stack([orbits.length_error + second + rounding, orbits.area_error + moved])
    return Check.measured("lengths", labels, deviation, allowed)


def _lambda(orbits: Orbits, path: _Path, labels: Sequence[str]) -> Check:
    """Check the stored lambda against the product of the monodromy matrices of all bounces.

    Words whose bounces on a semicircle are too close together to determine lambda are skipped.
    """
    middle, spread = _exponents(orbits, path)
    sure = np.flatnonzero(spread < _VAGUE * (1 + middle))
    deviation, allowed = np.abs(orbits.lyapunov - middle)[sure], (orbits.lyapunov_error + spread)[sure]
    return Check.measured("lambda", [labels[row] for row in sure.tolist()], deviation, allowed)


def _exponents(orbits: Orbits, path: _Path) -> tuple[Floats, Floats]:
    """Return lambda, computed from the bounces, and its possible error, each of shape (N,).

    Between the feet of the perpendiculars from the circles' centres, the matrices of
    `orbitdb.billiard.stability` have no negative entries: every bounce on a semicircle is a kick
    2 / sin(theta), and every link a drift by its length minus sin(theta) for each end on a semicircle (zero
    along a chord). So the smallest and largest kicks and drifts that the bounces allow give the smallest and
    largest lambda.
    """
    sine = path.sine.mean(axis=0)
    angle = path.tilt.max(axis=0)
    foot, loose_foot = (np.where(path.curved, part, 0.0) for part in (sine, angle))
    drift = path.links.after - foot - _next(foot)
    loose = path.stretch + loose_foot + _next(loose_foot)

    def exponents(shift: int) -> Floats:
        drifts = np.maximum(drift + shift * loose, 0.0)
        stiffness = np.where(path.curved, np.maximum(sine - shift * angle, 1e-9 * sine) / 2, np.inf)
        nothing = np.zeros_like(drifts.T)
        return exponent(Derivatives(nothing, nothing, drifts.T, stiffness.T))

    least, middle, greatest = (exponents(shift) for shift in (-1, 0, 1))
    spread = np.maximum(greatest - middle, middle - least)
    rounding = 12 * orbits.words.shape[1] * EPSILON + 4 * EPSILON * middle
    return middle, spread + rounding


def _hessian(orbits: Orbits, stadium: Stadium, path: _Path, labels: Sequence[str]) -> Check:
    """Check the signature of the Hessian, and lambda against its determinant.

    det H = prod(-b_i) (tr M - 2), where tr M = (-1)^(straight bounces) 2 cosh(lambda). Rows and columns are
    scaled so that entries are about 1, which preserves the signature and multiplies det H by a known factor.
    An eigenvalue moves by at most the norm of the error; to first order, ln |det H| moves by at most this
    norm times the sum of 1 / |eigenvalue|, and twice that is allowed. Words with an eigenvalue whose sign is
    undecided are skipped.
    """
    words, p = orbits.words, orbits.words.shape[1]
    own, coupling, loose, loose_coupling, sines = path.bend()
    scale = 1 / np.sqrt(own + sines)
    beside = scale * _next(scale)
    links = couplings_of(path.links, stadium.tangents(words, orbits.coordinates))
    matrix = hessian(stadium, words, orbits.coordinates) * scale[:, :, None] * scale[:, None, :]
    eigenvalues = np.linalg.eigvalsh(_finite(matrix))
    off, loose_off = coupling * beside, loose_coupling * beside
    norm = (loose * scale**2 + loose_off + _previous(loose_off)).max(axis=1)
    norm += 4 * p * EPSILON * (1 + off + _previous(off)).max(axis=1)
    sure = np.flatnonzero(np.abs(eigenvalues).min(axis=1) > 2 * norm)
    labels = [labels[row] for row in sure.tolist()]
    straights, eigenvalues, norm = STRAIGHT[words[sure]].sum(axis=1), eigenvalues[sure], norm[sure]

    exponent, sign = orbits.lyapunov[sure], 1.0 - 2.0 * (straights % 2)
    trace = exponent + 2 * np.log(np.abs(1 - sign * np.exp(-exponent)))
    size = np.abs(links * beside)[sure]
    identity = np.log(np.abs(eigenvalues)).sum(axis=1) - np.log(size).sum(axis=1) - trace
    allowed = 2 * norm * (1 / np.abs(eigenvalues)).sum(axis=1)
    allowed += (loose_coupling / coupling)[sure].sum(axis=1) + 8 * p * EPSILON
    allowed += np.tanh(exponent / 2) ** -sign * orbits.lyapunov_error[sure]
    deviation = np.where((eigenvalues > 0).sum(axis=1) == straights, np.abs(identity), np.inf)
    return Check.measured("Hessian", labels, deviation, allowed)


BOUNDED = {
    "coordinates": "error", "length": "length_error", "lyapunov": "lyapunov_error", "area": "area_error",
}  # fmt: skip

_SETTLED = 1e-6


def check_against(stored: Orbits, stadium: Stadium) -> Iterator[Check]:
    """Check stored orbits against new solutions: statuses must agree, and numbers agree within the bounds."""
    fresh = solve_admissible(stored.words, stadium)
    labels = to_strings(stored.words)
    sign = np.where(stored.status == Status.DYNAMICAL.value, -1.0, 1.0)
    wrong_side = (stored.status != Status.BOUNDARY.value) & ~(sign * stored.margin >= 0)
    undecided = stored.status == Status.UNRESOLVED.value
    yield Check.judged("statuses", labels, (stored.status != fresh.status) | wrong_side | undecided)
    both = np.flatnonzero(np.isin(stored.status, EXISTING) & np.isin(fresh.status, EXISTING))
    kept, solved = stored.rows(both), fresh.rows(both)
    apart = [np.abs(getattr(kept, name) - getattr(solved, name)) for name in BOUNDED]
    deviation = np.stack([distance.max(axis=1) if distance.ndim == 2 else distance for distance in apart])
    allowed = np.stack([getattr(kept, bound) + getattr(solved, bound) for bound in BOUNDED.values()])
    yield Check.measured("bounds", [labels[row] for row in both], deviation, allowed)


def restart(words: NDArray[np.uint8], stadium: Stadium, times: int, rng: np.random.Generator) -> Check:
    """Solve admissible words, shape (N, p), again from random directions within their limits, and compare.

    The rows of the check are the restarts that converged. The deviation is the largest difference of a
    direction, in radians; it must not exceed the sum of both error bounds.
    """
    joint = Check("restarts", 0)
    text = to_strings(words)
    for rows, legs in cut(words):
        labels = [text[row] for row in rows]
        first, first_error = _solved(legs, stadium.a)
        low, high = direction_limits(legs, stadium.a)
        for _ in range(times):
            again, error = _solved(legs, stadium.a, rng.uniform(low, high))
            rest = np.flatnonzero(error.max(axis=0) < _SETTLED)
            apart, allowed = np.abs(again - first)[:, rest], (error + first_error)[:, rest]
            joint = joint.joined(Check.measured("restarts", [labels[row] for row in rest], apart, allowed))
    return joint


def _solved(legs: Legs, a: float, start: Floats | None = None) -> tuple[Floats, Floats]:
    """Return the directions to which Newton's method converges, and bounds on their errors."""
    alpha = newton(legs, a, start=start).alpha
    return alpha, direction_errors(legs, a, alpha, derivatives(legs, a, alpha))


_BATCH = 256
_SHARP = 512
"""Precision in bits for rows whose bounds came from balls of the usual precision, which cannot prove them."""


def certify(path: Path, selection: Selection, sample: int | None = None, seed: int = 0) -> Generator[Checked]:
    """Prove the rows of the chosen classes in ball arithmetic, and store the certificates.

    Rows that have a certificate are skipped. Each batch is stored in one transaction; after an interruption,
    the next run continues from there. The parameters are those of `orbitdb.verification.verify.verify`.
    """
    place, stadium = f"at a = {format_float(selection.a)}", Stadium(selection.a)
    source = Store(path)
    with source.reading() as connection:
        scope = Scope(connection, sample=sample)
        number = scope.scalar("SELECT id FROM stadium WHERE a = :a", a=selection.a)
        if number is None:
            return
        chosen = scope.classes(selection, np.random.default_rng(seed))
        cycles = scope.query("SELECT cycle FROM certificate WHERE stadium = :stadium", stadium=number)
        certified = np.array(cycles, np.int64)
    todo = {p: np.setdiff1d(ids, certified) for p, ids in chosen.items()}
    with closing(Writer(path, {"command": "verify --prove", "a": selection.a})) as writer:
        for block in blocks(todo, _BATCH):
            with source.reading() as connection:
                scope = Scope(connection)
                ids, stored = stored_orbits(scope, selection.a, block)
                query = f"SELECT run FROM orbit WHERE stadium = :stadium AND cycle {LISTED} ORDER BY cycle"
                runs = [run for (run,) in scope.query(query, stadium=number, ids=block.ids)]
            check, proved, radii, precisions = prove(with_bounds(stored, stadium), stadium)
            rows = zip(ids.tolist(), runs, radii, precisions, strict=True)
            entries = [row for row, is_proved in zip(rows, proved, strict=True) if is_proved]
            with writer.transaction() as connection:
                replace_certificates(writer, connection, number, block.ids.tolist(), entries, __version__)
            stage = f"proofs {place}, p = {block.p}"
            yield Checked(stage, block.done, block.total, (check.at(place),))


def prove(stored: Orbits, stadium: Stadium) -> tuple[Check, list[bool], list[float], list[int]]:
    """Prove N stored rows in ball arithmetic.

    A row is proved if its status is that of the enclosure and, for an orbit, all coordinates, the length,
    lambda, the area and the margin differ from the true values by no more than the row's bounds.

    Returns
    -------
    check : Check
    proved : list of bool
    radius : list of float
        Proved distance of the stored coordinates from the true ones; 0 without coordinates.
    bits : list of int
        Precision of each proof.
    """
    enclosed = certificates(stored.words, stadium)
    deviation, allowed = _distances(stored, enclosed, stadium)
    doubtful = np.flatnonzero((shares(deviation, allowed) > 1).any(axis=0))
    sharper = certificates(stored.words[doubtful], stadium, _SHARP)
    deviation[:, doubtful], allowed[:, doubtful] = _distances(stored.rows(doubtful), sharper, stadium)
    bits = np.array([ball.precision for ball in enclosed], np.int64)
    bits[doubtful] = [ball.precision for ball in sharper]
    check = Check.measured("certificates", to_strings(stored.words), deviation, allowed)
    proved = np.all(shares(deviation, allowed) <= 1, axis=0)
    return check, proved.tolist(), deviation[0].tolist(), bits.tolist()


def _distances(stored: Orbits, enclosed: "Sequence[Enclosure]", stadium: Stadium) -> tuple[Floats, Floats]:
    """Return the distances of the stored numbers from the true ones, and the allowed ones, shape (5, N).

    The numbers are the coordinates, length, lambda, area and margin. All distances are infinite if the status
    is wrong, and 0 if the word is not an orbit. An area that an odd symmetry makes 0 is exact.
    """
    from orbitdb.orbits.balls import true_errors

    distances = true_errors(stored, enclosed)
    place = stored.error + rounding_of_positions(stadium)
    allowed = np.stack([stored.error, stored.length_error, stored.lyapunov_error, stored.area_error, place])
    stabilisers = np.array([class_of(word).stabiliser for word in to_strings(stored.words)], np.uint8)
    distances[3] = np.where(encloses_nothing(stabilisers), np.abs(stored.area), distances[3])
    status = np.array([ball.status.value for ball in enclosed], str)
    nothing = ~np.isin(status, EXISTING)
    distances[:, nothing], allowed[:, nothing] = 0.0, 1.0
    distances[:, (status != stored.status) | (status == Status.UNRESOLVED.value)] = np.inf
    return distances, allowed
