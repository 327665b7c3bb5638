"""The trajectory value of the statistics screen: the better one stays, and it is said which it is."""

import pytest
from screens import drive, press, shown

from orbitdb.cli.tui.statistics import averages as statistics
from orbitdb.numerals import with_error
from orbitdb.store.asking.selection import Selection
from orbitdb.store.writing.records import add_reference
from orbitdb.store.writing.writer import Writer
from orbitdb.trajectories.ensemble import Reference

LARGE = (160, 48)


@pytest.mark.slow
@pytest.mark.parametrize("error", [1e-9, 0.5])
def test_more_trajectories_replace_a_value_only_if_they_are_better(filled, monkeypatch, error):
    monkeypatch.setattr(statistics, "FIRST_BOUNCES", 100_000)
    kept = Reference(0.8867, error, 0.3752, error, 2.3, 0.1, 10**9, 16, 5)
    writer = Writer(filled, {"command": "test"})
    add_reference(writer, 1.6, kept)
    writer.close()

    async def steps(app, pilot):
        await press(pilot, "S")
        assert app.screen.reference == kept
        told = " ".join(shown(app).split())
        assert f"λ_d {with_error(kept.lambda_d, error).replace('+-', '±')}" in told
        assert "; stored" in told
        app.screen.take_reference(kept, 0.25, stored=False)
        await pilot.pause()
        assert "following more: 25%" in shown(app)
        await press(pilot, "t")
        better = min(error, 0.1)
        assert (app.screen.reference == kept) == (better == error)
        assert app.screen.reference.lambda_d_error <= better
        assert app.screen.reference.lambda_d == pytest.approx(0.8868, abs=0.05)
        assert ("not as good" in shown(app)) == (better == error)
        assert "bounces followed here" in shown(app)

    drive(filled, steps, LARGE, Selection(periods=((2, 3),)))
