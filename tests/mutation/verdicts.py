"""What became of mutants, and how many were noticed."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

KILLED, SURVIVED, LATE, NOBODY = "killed", "survived", "timed out", "never executed"
_ORDER = (KILLED, LATE, SURVIVED, NOBODY)


@dataclass(frozen=True)
class Verdict:
    """What became of a mutant.

    Attributes
    ----------
    wing, file, kind, before, after, outcome : str
    line : int
    by : str
        The test that noticed.
    tests, ran : int
        How many tests execute it, and how many of them were within `--most`.
    seconds : float
    """

    wing: str
    file: str
    line: int
    kind: str
    before: str
    after: str
    outcome: str
    by: str
    tests: int
    ran: int
    seconds: float


def of_the_wing(verdicts: Sequence[Verdict], population: Counter[tuple[str, str]]) -> float:
    """Return the part that is noticed of all mutants of some wings, as a sample by kinds tells it.

    Parameters
    ----------
    verdicts : sequence of Verdict
        Of every stratum, a wing and a kind, some.
    population : Counter
        How many mutants each stratum has.
    """
    strata: dict[tuple[str, str], list[bool]] = {}
    for verdict in verdicts:
        noticed = verdict.outcome in (KILLED, LATE)
        strata.setdefault((verdict.wing, verdict.kind), []).append(noticed)
    weights = {stratum: population[stratum] for stratum in strata}
    told = sum(weights[stratum] * sum(each) / len(each) for stratum, each in strata.items())
    return told / sum(weights.values())


def report(verdicts: Sequence[Verdict], population: Counter[tuple[str, str]]) -> str:
    """Return how many were killed, wing by wing, and what nobody noticed."""
    if not verdicts:
        return "there is nothing to alter"
    heads = "".join(f"{word:>16}" for word in (*_ORDER, "noticed", "of the wing"))
    lines = [f"{'wing':14}{'mutants':>8}{heads}"]
    for wing in (*sorted({verdict.wing for verdict in verdicts}), "all"):
        chosen = [verdict for verdict in verdicts if wing in (verdict.wing, "all")]
        count = Counter(verdict.outcome for verdict in chosen)
        numbers = "".join(f"{count[word]:>16}" for word in _ORDER)
        noticed = (count[KILLED] + count[LATE]) / count.total()
        lines.append(
            f"{wing:14}{count.total():>8}{numbers}{noticed:>16.0%}{of_the_wing(chosen, population):>16.0%}"
        )
    for verdict in sorted(verdicts, key=lambda verdict: (verdict.file, verdict.line)):
        if verdict.outcome in (SURVIVED, NOBODY):
            ran = f"{verdict.ran} of {verdict.tests} tests"
            lines += ["", f"{verdict.file}:{verdict.line}: {verdict.outcome} ({verdict.kind}, {ran})"]
            lines += [f"  - {verdict.before}", f"  + {verdict.after}"]
    return "\n".join(lines)


def shown(verdict: Verdict) -> str:
    """Return what became of a mutant, in a few lines."""
    place = f"{verdict.outcome}: {verdict.file}:{verdict.line} ({verdict.kind})"
    if verdict.outcome == KILLED:
        return f"{place} by {verdict.by or 'import'}, {verdict.seconds:.0f} s"
    change = f"  - {verdict.before}\n  + {verdict.after}"
    return f"{place} {verdict.ran} of {verdict.tests} tests, {verdict.seconds:.0f} s\n{change}"
