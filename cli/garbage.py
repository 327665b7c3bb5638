"""When Python looks for garbage: not while a command is being loaded, and not when it ends.

What is loaded stays for as long as the process. To go through it again and again, while it grows and once
more at the end, takes a fifth of the time of a short command.
"""

import gc
from typing import Literal

_LOADED = 100_000
"""More objects than the largest command loads."""


def collect_later() -> None:
    """Leave all that is made until the first collection uncollected, and put that off."""
    usual = gc.get_threshold()

    def settle(phase: Literal["start", "stop"], info: dict[str, int]) -> None:
        gc.callbacks.remove(settle)
        gc.freeze()
        gc.set_threshold(*usual)

    gc.callbacks.append(settle)
    gc.set_threshold(_LOADED)


def collect_no_more() -> None:
    """Leave what is there to the end of the process, which takes it all at once."""
    gc.freeze()
