"""What decides the last bit of a result besides the program: the libraries and the processor."""

import platform
from functools import cache
from importlib.metadata import version


@cache
def arithmetic() -> str:
    """Name what computes here; where it is the same, the same words give the same bits.

    NumPy chooses its sines and logarithms by the processor's vector instructions.
    """
    import numpy as np

    found = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    libraries = " ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "python-flint"))
    library = " ".join(part for part in platform.libc_ver() if part)
    return f"{libraries}, {platform.system()} {platform.machine()} {' '.join(found)}, {library}"
