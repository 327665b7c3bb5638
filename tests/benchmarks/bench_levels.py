"""Measure what the judgement of lists of levels supposes, and how long it takes.

Run it as ``python tests/benchmarks/bench_levels.py [NAME ...]`` with orbitdb installed. By default it does
all of what follows, which takes some minutes. docs/calibration.py measures how often statements are right.

errors
    The share of the fluctuations that the orbits miss at each length, against exact levels (`_KNOWN`, ...,
    in `orbitdb.quantum.staircase_errors`).
misfits
    Misfits of lists that belong to the stadium, and of others (`_SHORTFALL` and others in
    `orbitdb.quantum.judging`).
places
    How many lists are refused that lack a single level (`_PLACES` in `orbitdb.quantum.staircase_errors`).
powers
    How often statements are right, with the probabilities of the model as they are, and as they are stated
    (`_OF_GAPS` and others in `orbitdb.quantum.conclusions`).
times
    Seconds of processor time and the memory for lists of 134 to 20 000 levels.
"""

import math
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d

sys.path.insert(0, str(Path(__file__).parents[2] / "docs"))

from calibration import KINDS, PUBLIC, Source, Tally, exact, public, staircase_of, windows

from orbitdb import Catalogue, Stadium, read_levels
from orbitdb.quantum import conclusions, staircase_errors
from orbitdb.quantum.comparison import CUTOFF, smoothed
from orbitdb.quantum.missing_levels import assess
from orbitdb.quantum.weyl import Parity, wavenumber, weyl

LIST = (1.0, Parity.OO, 0.0, 60.0)
MIXED = (1.6, None, 4.0, 26.0)
"""Half length, parity and range of k of the exact levels."""


def errors(catalogue: Catalogue) -> None:
    """Print g(l), where g(l) exp(-(l/X)^2) / (pi^2 l) is the variance of the error of N_X per unit length."""
    source = exact(catalogue, *LIST)
    orbits = staircase_of(catalogue, source)
    k = np.arange(source.k[0] + 3, source.k[-1] - 1, 0.02)
    error = orbits.at(k)[0] - smoothed(k, source.k, CUTOFF)
    window = np.sin(math.pi * np.arange(len(k)) / len(k)) ** 2
    length = np.arange(0.05, 20, 0.1)
    wave = np.exp(1j * length[:, None] * k) @ (window * error) * 0.02
    power = np.abs(wave) ** 2 / (math.pi * 0.02 * (window**2).sum())
    share = power * math.pi**2 * length * np.exp((length / CUTOFF) ** 2)
    print(f"rms error {error.std():.3f}, half the perimeter {Stadium(source.a).perimeter / 2:.2f}")
    for part in np.split(np.arange(len(length)), 20):
        print(f"length {length[part[0]]:4.1f} to {length[part[-1]]:4.1f}: g = {share[part].mean():.4f}")


def misfits(catalogue: Catalogue) -> None:
    """Print the misfits of lists with missing and spurious levels, and of lists that do not belong."""
    rng = np.random.default_rng(3)
    for source in (exact(catalogue, *LIST), public()[0]):
        orbits = staircase_of(catalogue, source)
        other = source._replace(k=made(catalogue, source.k[0], 800, Parity.EE))
        for length in (30, 60, 150, 400):
            for kind in KINDS:
                some = windows(rng, source, length, kind, 12)
                show(source, orbits, f"{length} levels, {kind.name}", [window.k for window in some])
            whole = [window.k for window in windows(rng, source, length, KINDS[0], 12)]
            foreign = windows(rng, other, length, KINDS[0], 12)
            show(source, orbits, f"{length} levels of another parity", [window.k for window in foreign])
            show(source, orbits, f"{length} random numbers", [random_numbers(rng, k) for k in whole])
            show(source, orbits, f"{length} levels of random matrices", [matrix(rng, k) for k in whole])
            show(source, orbits, f"{length} levels, radius 0.1 % off", [k * 1.001 for k in whole])


def show(source, orbits, name, lists) -> None:
    """Print the misfits of lists."""
    found = [assess(k, orbits, Stadium(source.a), source.parity, window=True).misfit for k in lists]
    low, middle, high = np.quantile(found, [0.0, 0.5, 1.0])
    print(f"k = {source.k[0]:.0f}, {name}: misfit {low:.2f} to {high:.2f}, median {middle:.2f}", flush=True)


def random_numbers(rng, k):
    """Return as many random numbers as levels in the same range."""
    return np.sort(rng.uniform(k[0], k[-1], len(k)))


def matrix(rng, k):
    """Return the middle eigenvalues of a random matrix, scaled to the range of a list."""
    size = 3 * len(k)
    full = rng.normal(size=(size, size))
    middle = np.linalg.eigvalsh(full + full.T)[len(k) : 2 * len(k)]
    return k[0] + (middle - middle[0]) / (middle[-1] - middle[0]) * (k[-1] - k[0])


def places(catalogue: Catalogue) -> None:
    """Print how many lists without one of their levels are refused, with some factors on the scatter."""
    usual = staircase_errors._PLACES
    for factor in (1.0, usual, 2.0):
        staircase_errors._PLACES = factor
        for a, parity, k_max in ((1.6, Parity.EE, 16.0), (2.6, Parity.OO, 12.0), (2.6, Parity.OE, 12.0)):
            source = exact(catalogue, a, parity, 0.0, k_max)
            orbits, k = staircase_of(catalogue, source), source.k
            lists = [np.delete(k, n) for n in range(len(k) - 1)]
            refused = sum(not assess(each, orbits, Stadium(a), parity).fits for each in lists)
            print(f"factor {factor}, a = {a}, {parity}: {refused} of {len(lists)} refused", flush=True)
    staircase_errors._PLACES = usual


def powers(catalogue: Catalogue) -> None:
    """Print calibrations with the probabilities of the model as they are, and with those that are stated."""
    names = ("_OF_GAPS", "_OF_GAPS_MIXED", "_OF_FIRST", "_BY_MISSING", "_BY_HIDDEN", "_MOST_MIXED")
    usual = [getattr(conclusions, name) for name in names]
    for values in ([1.0, 1.0, 1.0, 0.0, 0.0, 0.999], usual):
        for name, value in zip(names, values, strict=True):
            setattr(conclusions, name, value)
        print(f"powers {values}")
        for source in (exact(catalogue, *LIST), exact(catalogue, *MIXED), public()[0]):
            orbits, rng = staircase_of(catalogue, source), np.random.default_rng(5)
            for kind in KINDS:
                tally = Tally()
                tally.measure(orbits, windows(rng, source, 100, kind, 60))
                print(f"k = {source.k[0]:.0f}, {kind.name}:", *tally.row(), sep=" | ", flush=True)


def times(catalogue: Catalogue) -> None:
    """Print processor times for the window 776.4 to 777, a list from 0, and 20 000 levels from 700 on."""
    k = read_levels(PUBLIC)
    clocked(catalogue, "134 levels at 776", k[(k > 776.4) & (k < 777)], window=True)
    from_orbits = catalogue.levels(161.0, parity="oo", method="orbits", a=1.0).k
    clocked(catalogue, f"{len(from_orbits)} levels from 0", from_orbits)
    clocked(catalogue, "20 000 levels from 700", made(catalogue, 700.0, 20_000), window=True)
    print(f"at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB in all")


def clocked(catalogue: Catalogue, name: str, k, window: bool = False) -> None:
    """Print the processor time for a list."""
    began = time.process_time()
    found = catalogue.assess(k, parity="oo", window=window, a=1.0)
    print(f"{name}: {time.process_time() - began:.2f} s; {found.verdict()}", flush=True)


def made(catalogue: Catalogue, low: float, count: int, parity: Parity = Parity.OO):
    """Return a made-up list: the staircase from the orbits, with the spacings of random matrices.

    What random matrices add to the staircase beyond the resolution of the orbits is taken away.
    """
    smooth = weyl(Stadium(1.0), parity)
    high = wavenumber(smooth, max(smooth(low), 0.0) + count)
    orbits = staircase_of(catalogue, Source(1.0, parity, np.array([max(low, 1.0), high]), 0))
    numbers = np.arange(max(math.ceil(orbits.count[0][0]), 0), orbits.count[0][-1]) + 0.5
    rng, blocks = np.random.default_rng(1), np.array_split(numbers, math.ceil(len(numbers) / 200))
    off = np.concatenate([matrix(rng, block) for block in blocks]) - numbers
    off -= gaussian_filter1d(off, smooth.deriv()(low) / CUTOFF)
    k = np.interp(numbers + off, np.maximum.accumulate(orbits.count[0]), orbits.k)
    return np.sort(k[k > low])[:count]


REPORTS = {report.__name__: report for report in (errors, misfits, places, powers, times)}

if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        filled = Catalogue.create(Path(folder) / "orbits.db", 1.0)
        filled.fill("2-12")
        for other in (1.6, 2.6):
            filled.fill("2-12", a=other)
        for name in sys.argv[1:] or REPORTS:
            REPORTS[name](filled)
