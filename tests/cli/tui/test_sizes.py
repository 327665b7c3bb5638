"""Lists and dialogs open in windows of any size, and follow when a window shrinks to nothing."""

import pytest
from quick import fuzz_but
from screens import browsing

KEYS = ("O", "s", "ctrl+p", "C", "f", "question_mark", "e", "c")
IN_CI = ((4, 5),)
OTHERS = ((1, 1), (2, 3), (3, 24), (5, 2), (6, 24), (7, 1), (40, 1))


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height"), fuzz_but(IN_CI, [*IN_CI, *OTHERS]))
async def test_every_dialog_opens_in_any_window_and_resizes(filled_once, width, height):
    async with browsing(filled_once, size=(width, height)) as (app, pilot):
        for key in KEYS:
            await pilot.press(key)
            await pilot.pause()
            for other in ((1, 1), (80, 24), (width, height)):
                await pilot.resize_terminal(*other)
                await pilot.pause()
            await pilot.press("escape")
        assert app.is_running
