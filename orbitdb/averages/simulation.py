"""Averages over random trajectories, which are followed bounce by bounce or leg by leg."""

from collections.abc import Callable

from orbitdb.averages.exact_means import exact_means
from orbitdb.billiard.stadium import Stadium, as_stadium
from orbitdb.errors import InputError, check_int
from orbitdb.trajectories.ensemble import Reference, references
from orbitdb.trajectories.legwise import simulate_legs


def simulate(
    stadium: Stadium | float,
    bounces: int,
    seed: int = 0,
    trajectories: int | None = None,
    progress: Callable[[float, Reference], None] | None = None,
    *,
    legwise: bool = False,
) -> Reference:
    """Average over random trajectories.

    Parameters
    ----------
    stadium : Stadium or float
        The stadium, or its half length.
    bounces : int
        Expected total number of bounces. A small number is exceeded, because every trajectory has at least
        one bounce on a semicircle.
    seed : int, optional
        Seed of the random numbers; the same arguments give the same result.
    trajectories : int, optional
        Number of trajectories; by default from 256, which the errors need, to 4096.
    progress : callable, optional
        Called every few hundred steps with the fraction done and the averages so far.
    legwise : bool, optional
        Whether to sample leg by leg and use exact means, which makes the errors much smaller; the number of
        trajectories then follows from the number of bounces.

    Raises
    ------
    InputError
        If `bounces` is below 1, or too small for an error at a small half length, if `trajectories` is below
        2, or if you give `trajectories` with `legwise`.

    Examples
    --------
    >>> from orbitdb import simulate
    >>> found = simulate(1.6, 100_000, seed=7, legwise=True)
    >>> abs(found.lambda_d - 0.88679) < 3 * found.lambda_d_error < 0.003
    True
    """
    stadium, wanted = as_stadium(stadium), check_int("bounces", bounces, 0)
    if not legwise:
        for done, averages in references(stadium, wanted, seed, trajectories):
            if progress is not None:
                progress(done, averages)
        return averages
    if trajectories is not None:
        raise InputError("trajectories does nothing with legwise=True: leave it out")
    return simulate_legs(stadium, wanted, exact_means(stadium.a).growth, seed, progress)
