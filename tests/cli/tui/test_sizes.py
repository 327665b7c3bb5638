"""Lists and dialogs open in windows of any size, and follow when a window shrinks to nothing."""

import pytest
from quick import fuzz_but, slow_but
from screens import browsing

LISTS = ("O", "s", "ctrl+p")
ALL = (*LISTS, "C", "f", "question_mark", "e", "c")
QUICK = ((6, 24), LISTS[:1])
IN_CI = [(size, ALL) for size in ((1, 1), (2, 3), (4, 5), (6, 24), (40, 1))]
OTHERS = [(size, ALL) for size in ((3, 24), (5, 2), (7, 1))]


@pytest.mark.parametrize(("size", "keys"), [*slow_but([], [QUICK, *IN_CI]), *fuzz_but([], OTHERS)])
async def test_every_dialog_opens_in_any_window_and_resizes(filled_once, size, keys):
    async with browsing(filled_once, size=size) as (app, pilot):
        for key in keys:
            await pilot.press(key)
            await pilot.pause()
            for other in ((1, 1), (80, 24), size):
                await pilot.resize_terminal(*other)
                await pilot.pause()
            await pilot.press("escape")
        assert app.is_running
