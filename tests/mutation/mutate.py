"""Mutation testing: alter the code, a place at a time, and tell what no test notices.

``python tests/mutation/mutate.py billiard store --sample 20 --seed 1`` tries twenty mutants of each of two
wings; without names, of every wing. The tests that execute the altered line run, those of its wing first,
quick ones before long ones, in a copy of the tree, which all processes of a test import. The first run finds
out which tests execute what, and keeps it in ``.mutation`` until something is altered. ``--at FILE:LINE``
tries a line again; ``--tests "not fuzz"`` asks all tests that CI runs.

A sample has of each kind of mistake as many as of the others, so that rare and stealthy ones are seen; the
last column is what it tells of the whole wing, each kind counted as often as it occurs there.
"""

import argparse
import random
import signal
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from itertools import islice, zip_longest
from pathlib import Path
from queue import SimpleQueue
from time import monotonic

from executed import Executed, executed
from mutants import Mutant, differs, mutants
from tree import Tree, end_all, ended
from verdicts import KILLED, LATE, NOBODY, SURVIVED, Verdict, report, shown

ROOT = Path(__file__).parents[2]
_START = 60.0
"""Seconds that a mutant may take beside those of its tests."""


@dataclass(frozen=True)
class Chosen:
    """A mutant, its wing, and the tests that execute it: how many, and those that are run."""

    wing: str
    mutant: Mutant
    source: str
    tests: int
    run: list[str]
    limit: float

    def verdict(self, outcome: str, by: str, seconds: float) -> Verdict:
        """Return what became of it."""
        before, after = self.mutant.shown(self.source)
        line = self.mutant.line(self.source)
        place = (self.wing, self.mutant.path, line, self.mutant.kind)
        return Verdict(*place, before, after, outcome, by, self.tests, len(self.run), round(seconds, 1))


def sample(
    paths: Sequence[str],
    sources: dict[str, str],
    size: int | None,
    seed: int,
    wanted: Callable[[Mutant, str], bool] = lambda mutant, source: True,
) -> list[Mutant]:
    """Return some mutants of some files, or all: of each kind in turn, and whatever is altered elsewhere."""
    kinds: dict[str, list[Mutant]] = {}
    for path in paths:
        for mutant in filter(
            lambda mutant: wanted(mutant, sources[mutant.path]), mutants(path, sources[path])
        ):
            kinds.setdefault(mutant.kind, []).append(mutant)
    for alike in kinds.values():
        alike.sort(key=lambda mutant: mutant.rank(sources[mutant.path], seed))
    in_turn = (mutant for row in zip_longest(*kinds.values()) for mutant in row if mutant is not None)
    return list(islice((mutant for mutant in in_turn if differs(mutant, sources[mutant.path])), size))


def counted(wings: dict[str, list[str]], sources: dict[str, str]) -> Counter[tuple[str, str]]:
    """Return how many mutants of each kind each wing has."""
    return Counter(
        (wing, mutant.kind)
        for wing, paths in wings.items()
        for path in paths
        for mutant in mutants(path, sources[path])
    )


def within(known: Executed, tests: list[str], most: float) -> list[str]:
    """Return the first tests, as many as take no longer than so many seconds; at least one."""
    kept, spent = [], 0.0
    for test in tests:
        spent += known.tests[test]["seconds"]
        if kept and spent > most:
            break
        kept.append(test)
    return kept


def _wanted(options: argparse.Namespace) -> Callable[[Mutant, str], bool]:
    """Return what tells whether a mutant is to be tried at all."""
    if options.at:
        return lambda mutant, source: f"{mutant.path}:{mutant.line(source)}" in options.at
    return lambda mutant, source: True


def choose(tree: Tree, sources: dict[str, str], known: Executed, options: argparse.Namespace) -> list[Chosen]:
    """Return what is to be tried, wings mixed."""
    wings = tree.wings()
    wanted = _wanted(options)
    found = []
    for wing in options.wings or wings:
        for mutant in sample(wings[wing], sources, options.sample, options.seed, wanted):
            tests = known.tests_of(mutant, sources)
            run = within(known, tests, options.most)
            limit = _START + options.patience * sum(known.tests[test]["seconds"] for test in run)
            found.append(Chosen(wing, mutant, sources[mutant.path], len(tests), run, limit))
    random.Random(options.seed).shuffle(found)
    return found


def run_tests(copy: Tree, tests: Sequence[str], limit: float, *more: str) -> tuple[int | None, str]:
    """Run tests in a copy, in their order; return the exit code and what pytest wrote."""
    beside = copy.root.parent
    listed, log = beside / "tests.txt", beside / "log.txt"
    listed.write_text("\n".join(tests))
    arguments = ["-n", "0", "-q", "-m", "", "--tb=no", "-rfE", "--hypothesis-seed=1", *more]
    running = copy.start_tests([*arguments, f"--basetemp={beside / 't'}", f"@{listed}"], log)
    return ended(running, copy, limit), log.read_text(errors="replace")


def first_failure(log: str) -> str:
    """Return the test that failed; empty if the mutant does not even let the tests be found."""
    for line in log.splitlines():
        for word in ("FAILED ", "ERROR "):
            if line.startswith(word):
                return line.removeprefix(word).partition(" - ")[0]
    return ""


def judge(copy: Tree, chosen: Chosen) -> Verdict:
    """Try a mutant in a copy of the tree."""
    if not chosen.run:
        return chosen.verdict(NOBODY, "", 0.0)
    began = monotonic()
    file = copy.root / chosen.mutant.path
    file.write_text(chosen.mutant.applied(chosen.source))
    try:
        code, log = run_tests(copy, chosen.run, chosen.limit, "-x")
    finally:
        file.write_text(chosen.source)
    outcome = LATE if code is None else KILLED if code else SURVIVED
    return chosen.verdict(outcome, first_failure(log) if code else "", monotonic() - began)


def judged(tree: Tree, chosen: Sequence[Chosen], jobs: int, folder: Path) -> Iterator[Verdict]:
    """Try mutants in so many copies at a time, then the tests that noticed without a mutant."""
    copies: SimpleQueue[Tree] = SimpleQueue()
    for k in range(jobs):
        (folder / str(k)).mkdir()
        copies.put(tree.copy(folder / str(k) / "tree"))

    def in_a_copy(each: Chosen) -> Verdict:
        copy = copies.get()
        try:
            return judge(copy, each)
        finally:
            copies.put(copy)

    verdicts = []
    with ThreadPoolExecutor(jobs) as threads:
        try:
            for verdict in threads.map(in_a_copy, chosen):
                verdicts.append(verdict)
                print(shown(verdict), file=sys.stderr, flush=True)
        except BaseException:
            threads.shutdown(wait=False, cancel_futures=True)
            end_all()
            raise
    yield from _controlled(copies.get(), verdicts)


def _controlled(copy: Tree, verdicts: Sequence[Verdict]) -> Iterator[Verdict]:
    """Give the verdicts; a test that fails without a mutant, too, has noticed nothing."""
    killers = sorted({verdict.by for verdict in verdicts if verdict.by})
    failing = set()
    if killers:
        _, log = run_tests(copy, killers, 1e4)
        failing = {killer for killer in killers if f"FAILED {killer}" in log or f"ERROR {killer}" in log}
        for killer in failing:
            print(f"fails without a mutant, too: {killer}", file=sys.stderr)
    for verdict in verdicts:
        yield replace(verdict, outcome=SURVIVED) if verdict.by in failing else verdict


def parse(arguments: Sequence[str] | None, wings: Sequence[str]) -> argparse.Namespace:
    """Return the options."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "wings", nargs="*", metavar="WING", help=f"one or more of {', '.join(wings)}; else all"
    )
    parser.add_argument("--sample", type=int, metavar="N", help="mutants of each wing; else every mutant")
    parser.add_argument("--seed", type=int, default=1, help="which ones: the same for the same code")
    parser.add_argument(
        "--at", action="append", metavar="FILE:LINE", help="only those of this line; repeatable"
    )
    parser.add_argument(
        "--tests", metavar="EXPR", help="pytest's -m: 'not fuzz' for those of CI; else the default ones"
    )
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument("--most", type=float, default=60.0, metavar="S", help="seconds of tests for a mutant")
    parser.add_argument(
        "--patience", type=float, default=6.0, metavar="X", help="times what tests take; more if it is busy"
    )
    options = parser.parse_args(arguments)
    for wing in options.wings:
        if wing not in wings:
            parser.error(f"no wing is named {wing!r}: {', '.join(wings)}")
    if options.sample and options.at:
        parser.error("--at tries all that it names: leave out --sample")
    return options


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> None:
    """Run the command."""
    signal.signal(
        signal.SIGTERM, lambda *_: sys.exit(143)
    )  # so that what runs is ended, and copies are removed
    tree = Tree(root)
    options = parse(arguments, list(tree.wings()))
    wings = tree.wings()
    sources = {path: (tree.root / path).read_text() for paths in wings.values() for path in paths}
    known = executed(tree, tree.root / ".mutation", options.jobs, options.tests)
    with tempfile.TemporaryDirectory(prefix="m-", ignore_cleanup_errors=True) as folder:
        verdicts = list(judged(tree, choose(tree, sources, known, options), options.jobs, Path(folder)))
    print(report(verdicts, counted(wings, sources)))


if __name__ == "__main__":
    main()
