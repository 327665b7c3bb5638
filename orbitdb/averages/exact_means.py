"""The exact means of a stadium, and bounds on lambda that need no orbit and no trajectory."""

import math
from dataclasses import dataclass
from functools import lru_cache

from orbitdb.averages.drift_and_kick import LOG_KICK, Mean, log_drift
from orbitdb.averages.mean_coupling import mean_coupling


@dataclass(frozen=True)
class ExactMeans:
    """Means over the invariant measure, of a leg with its run.

    Attributes
    ----------
    a : float
        Half the length of a straight wall.
    log_drift, log_kick, coupling : Mean
        Of ln D, ln K and c2 = ln(1 + (1/D_before + 1/D_after)/K).
    """

    a: float
    log_drift: Mean
    log_kick: Mean
    coupling: Mean

    @property
    def terms(self) -> tuple[Mean, Mean, Mean]:
        """All of them."""
        return self.log_drift, self.log_kick, self.coupling

    @property
    def growth(self) -> Mean:
        """The mean of ln D + ln K + c2: lambda of a leg is a little less."""
        return Mean(
            math.fsum(mean.value for mean in self.terms), math.fsum(mean.error for mean in self.terms)
        )

    @property
    def bounds(self) -> tuple[float, float]:
        """Numbers below and above lambda of a leg: without c2, and with it, the errors on the safe side.

        The beam that comes to a run has a convergence between 0 and 1/D_before, so the last term of
        lambda is between 0 and c2.
        """
        low = self.log_drift.value + self.log_kick.value - self.log_drift.error - self.log_kick.error
        growth = self.growth
        return low, growth.value + growth.error

    @property
    def per_bounce(self) -> float:
        """What lambda of a leg is multiplied by to have lambda_d: a leg and its run have a + pi/2 bounces."""
        return 1 / (self.a + math.pi / 2)

    @property
    def per_length(self) -> float:
        """What lambda of a leg is multiplied by to have lambda_c: the path to the next run is so long."""
        return 1 / (math.pi * (math.pi + 4 * self.a) / 4)


@lru_cache(maxsize=32)
def exact_means(a: float) -> ExactMeans:
    """Return the exact means at half length a."""
    return ExactMeans(a, log_drift(a), LOG_KICK, mean_coupling(a))
