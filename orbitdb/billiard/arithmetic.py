"""The arithmetic on which the last bits of results depend, and what the error bounds assume about it.

Error bounds in double precision assume IEEE 754: sums, products, quotients and square roots are correctly
rounded. They assume that NumPy sums contiguous rows pairwise (`orbitdb.billiard.legs.summation_rounding`),
and that its elementary functions are as accurate as `UNITS` says, for arguments between -pi and pi (sin, cos)
or above 0. `check_functions` tests this once per process, with arguments whose results are hard to round and
with arguments close to pi/2, where a careless reduction of the argument would show.
"""

import platform
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version

from orbitdb.errors import WorkError

FORMULAS = 3
"""Version of the formulas that decide the bits of stored numbers; raise it if one of them changes."""

EPSILON = sys.float_info.epsilon
"""Twice the largest relative rounding error of a single operation."""

ABOVE = 1 + 2.0**-40
"""Factor that covers the rounding in computing a bound, by up to 4096 operations on positive numbers."""

UNITS = {"sin": 1, "cos": 1, "arctan": 1, "log": 1, "arcsinh": 2, "tanh": 2}
"""Largest error that is assumed of NumPy's functions, in units in the last place of the result."""

# fmt: off
HARD = {
    "sin": (
        (1e-06, 0.2280382552435078, 0.7853981633974483, 1.1528972715016594, 1.5707963267948966,
         2.6531053972315792, 3.0223194827540945, 3.141592653589793),
        (9.999999999998333e-07, 0.22606700113630226, 0.7071067811865475, 0.9139436066753207, 1.0,
         0.4692906067699583, 0.11899057346052642, 1.2246467991473532e-16),
    ),
    "cos": (
        (1e-06, 0.7853981633974483, 1.4443821753861648, 1.5707953867948965, 1.5707963267938965,
         1.5707963267948966, 1.9983113797990082, 3.141592653589793),
        (0.9999999999995, 0.7071067811865476, 0.12607772598266162, 9.40000000121431e-07,
         1.0001501329222983e-12, 6.123233995736766e-17, -0.4146107859648564, -1.0),
    ),
    "arctan": (
        (9.4e-07, 0.06712237338682625, 0.2696196957766377, 1.0, 2.909110631529902, 3.112191884253432,
         1062500.0, 1000000000000.0),
        (9.399999999997231e-07, 0.06702184034152915, 0.2633573367383249, 0.7853981633974483,
         1.239702334283471, 1.2598992196796914, 1.570795385618426, 1.5707963267938967),
    ),
    "log": (
        (0.5, 1.5, 2.0, 8.901361915039177, 30.217551667236926, 73.58543939810798, 1e60, 1e120),
        (-0.6931471805599453, 0.4054651081081644, 0.6931471805599453, 2.186204289192797,
         3.408422936594869, 4.298447171898213, 138.15510557964274, 276.3102111592855),
    ),
    "arcsinh": (
        (1e-06, 0.2366554536504628, 0.4972442972218927, 0.9258804724020964, 1.153112406001049, 20.0,
         1e30, 1e60),
        (9.999999999998333e-07, 0.23450032539052662, 0.4787456921291979, 0.8279803774632547,
         0.985606875667863, 3.6895038689889055, 69.77069997038132, 138.84825276020268),
    ),
    "tanh": (
        (1e-06, 0.5036, 0.5142901764261715, 0.5228358309879988, 0.5479874157178471, 1.0, 5.0, 20.0),
        (9.999999999996666e-07, 0.464943654665623, 0.4732811501362105, 0.4798857473539046,
         0.49901030153971376, 0.7615941559557649, 0.9999092042625951, 1.0),
    ),
}
# fmt: on
"""Exact arguments, and the correctly rounded results (from 300-bit arithmetic)."""


_balls = threading.RLock()


@contextmanager
def ball_precision(bits: int) -> Iterator[None]:
    """Compute with balls of the given precision, one thread at a time; then restore the caller's precision.

    Flint has one precision for the whole process, so a thread that changed it would change the digits of
    others.
    """
    from flint import ctx

    with _balls, ctx.workprec(bits):
        yield


class RoundingError(WorkError):
    """This machine's elementary functions are less accurate than the error bounds assume."""


@cache
def arithmetic() -> str:
    """Return a string that identifies this machine's arithmetic; where it is the same, so are all bits.

    The processor's vector instructions decide which sines and logarithms NumPy uses.
    """
    import numpy as np

    vectors = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])  # absent if there are none
    libraries = " ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "python-flint"))
    library = " ".join(part for part in platform.libc_ver() if part)
    machine = f"{platform.system()} {platform.machine()} {' '.join(vectors)}"
    return f"bounds {FORMULAS}, {libraries}, {machine}, {library}"


@cache
def check_functions() -> None:
    """Check on the first call that NumPy's elementary functions are as accurate as `UNITS` says.

    The arguments are passed as arrays, in both orders, because vector instructions then compute the results.

    Raises
    ------
    RoundingError
        If a function is less accurate.
    """
    import numpy as np

    for name, (arguments, results) in HARD.items():
        for order in (1, -1):
            exact = np.array(results[::order])
            computed = getattr(np, name)(np.array(arguments[::order]))
            worst = (np.abs(computed - exact) / np.spacing(np.abs(exact))).max()
            if not worst <= UNITS[name]:
                raise RoundingError(
                    f"NumPy's {name} is off by {worst:.3g} units in the last place here, but error bounds"
                    f" assume at most {UNITS[name]}: install another build or version of NumPy"
                )
