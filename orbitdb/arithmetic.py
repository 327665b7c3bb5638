"""What decides the bits of a result besides the program, and all that is assumed of it.

Error bounds in doubles assume IEEE 754: sums, products, quotients and square roots correctly rounded.
Of NumPy they assume that sums over contiguous rows go in pairs (`orbitdb.billiard.legs.summation_rounding`),
and of its elementary functions what `UNITS` says, for arguments between -pi and pi (sin, cos) or above 0.
`check_functions` tries that, once a process, on arguments that are hard to round or close to pi/2,
where a careless reduction of the argument would show.
"""

import platform
import sys
from functools import cache
from importlib.metadata import version

from orbitdb.errors import WorkError

BOUNDS = 3
"""Counts the changes of any formula that decides the bits of a stored number."""

EPSILON = sys.float_info.epsilon
"""Twice the largest relative rounding error of one operation."""

ABOVE = 1 + 2.0**-40
"""Factor that covers the rounding of a bound's own evaluation: up to 4096 operations on positive numbers."""

UNITS = {"sin": 1, "cos": 1, "arctan": 1, "log": 1, "arcsinh": 2, "tanh": 2}
"""Largest error of NumPy's functions in units in the last place of the result, as is assumed."""

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
"""Arguments, exact, and the results rounded correctly (by 300-bit arithmetic)."""


class RoundingError(WorkError):
    """This machine's elementary functions are worse than the error bounds assume."""


@cache
def arithmetic() -> str:
    """Name what computes here; where it is the same, the same words give the same bits.

    NumPy chooses its sines and logarithms by the processor's vector instructions.
    """
    import numpy as np

    found = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    libraries = " ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "python-flint"))
    library = " ".join(part for part in platform.libc_ver() if part)
    return (
        f"bounds {BOUNDS}, {libraries}, {platform.system()} {platform.machine()} {' '.join(found)}, {library}"
    )


@cache
def check_functions() -> None:
    """Check, the first time it is called, what is assumed of NumPy's elementary functions.

    A result may differ from the correctly rounded one by no more units than `UNITS` says. Whole arrays
    are tried, forwards and backwards, since vector instructions compute them.

    Raises
    ------
    RoundingError
        If one is worse.
    """
    import numpy as np

    for name, (arguments, results) in HARD.items():
        for order in (1, -1):
            exact = np.array(results[::order])
            found = getattr(np, name)(np.array(arguments[::order]))
            worst = (np.abs(found - exact) / np.spacing(np.abs(exact))).max()
            if not worst <= UNITS[name]:
                raise RoundingError(
                    f"NumPy's {name} is off by {worst:.3g} units in the last place here, and error bounds"
                    f" assume at most {UNITS[name]}: install another build or version of NumPy"
                )
