"""Draw the pictures of README.md and of the pages here with the current code.

    python docs/pictures.py                  draws all pictures
    python docs/pictures.py browse.svg       draws the pictures that are named

They are drawn in a folder with nothing but the catalogue of ``orbitdb fill --p 11`` and one `simulate`.
`work-precision.svg` measures run times for a minute: draw it on an otherwise idle machine.
`entropy-width.svg` measures processor time for a minute.
"""

import argparse
import asyncio
import re
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from console import CATALOGUE, FIRST_FILL, Session, lay

PICTURES = Path(__file__).parent
SCREEN = (150, 42)
SECONDS = 10.0
"""Processor time for the bounds at each a."""
SHOWN = "1232131"
"""The orbit of the paper's Fig. 1, shown in the pictures of the screen and of single orbits."""


def _screen(*keys: str) -> Callable[[Path], str]:
    """Return a function that takes a screenshot of the terminal UI after the given keys are pressed."""

    def draw(folder: Path) -> str:
        return plain_screenshot(asyncio.run(_taken(folder, keys)))

    return draw


async def _taken(folder: Path, keys: tuple[str, ...]) -> str:
    from orbitdb import Selection, Status
    from orbitdb.cli.tui.app import BrowseApp

    app = BrowseApp(folder / CATALOGUE, Selection(statuses=(Status.ORBIT,)), SHOWN)
    async with app.run_test(size=SCREEN) as pilot:
        for key in ("", *keys):
            await pilot.press(*filter(None, [key]))
            await pilot.pause()
            while app.workers:  # a size that comes late begins work anew
                await app.workers.wait_for_complete()
                await pilot.pause()
        return app.export_screenshot(title="orbitdb browse")


def plain_screenshot(svg: str) -> str:
    """Remove from a screenshot the ids that change every time, and the fonts that it would fetch."""
    svg = re.sub(r"@font-face \{.*?\}\s*", "", svg, flags=re.DOTALL)
    return re.sub(r"terminal-\d+", "terminal", svg)


def deviations(folder: Path) -> str:
    """Draw the deviation of every average of lambda from that of trajectories, against the period."""
    import numpy as np
    from matplotlib.ticker import MaxNLocator

    from orbitdb import Selection, Stadium, Status
    from orbitdb.answers.complete_periods import read_complete_periods, sum_rules_of
    from orbitdb.averages.by_period import lyapunov_of_periods
    from orbitdb.averages.exact_means import exact_means
    from orbitdb.plots.style import BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, figure, save
    from orbitdb.store.file import reading
    from orbitdb.trajectories.legwise import simulate_legs

    with reading(folder / CATALOGUE) as moment:
        subset = read_complete_periods(moment, Selection(a=1.6, statuses=(Status.ORBIT,)))
    found, held = lyapunov_of_periods(subset.sums(), subset.highest), sum_rules_of(subset)
    assert held is not None  # every period is filled
    means = exact_means(1.6)
    known = simulate_legs(Stadium(1.6), 20_000_000, means.growth).lambda_d
    averages = {
        "fixed points, Eq. (6)": found.lambda_d,
        "mean of $p - 1$ and $p$": found.lambda_d_pair,
        "zeta function": found.lambda_d_zeta,
        "sum rules, one mean less": held.lambda_l_below * Stadium(1.6).legs_per_bounce,
        "sum rules": held.lambda_d_sum_rule,
    }
    with figure(7.2, 4.8) as made:
        ax = made.add_subplot()
        looks = (("x:", BLUE), ("^-", GREEN), ("s--", ORANGE), ("D-", PURPLE), ("o-", INK))
        for (name, values), (look, colour) in zip(averages.items(), looks, strict=True):
            ax.plot(found.p, np.abs(values / known - 1), look, color=colour, markersize=5, label=name)
        ax.set(yscale="log", xlabel="period $p$ (bounces)", ylabel="relative deviation")
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
        low, high = ax.get_ylim()
        estimate = held.lambda_d_sum_rule_error / known
        ax.fill_between(
            found.p, low, estimate, color=FAINT, alpha=0.3, linewidth=0, label="estimate of its error"
        )
        ax.set_ylim(low, high)
        ax.set_title(r"$\lambda_d$ at $a = 1.6$ against trajectories leg by leg")
    save(made, folder / "figure.svg", "svg", "deviations of Lyapunov averages")
    return (folder / "figure.svg").read_text(encoding="utf-8")


def symbols(folder: Path) -> str:
    """Draw two orbits, mirror images of each other, which together have all six symbols."""
    from orbitdb import Stadium, solve_word
    from orbitdb.plots.paths import draw_orbit
    from orbitdb.plots.style import GREY, SMALL, figure, save

    with figure(7.2, 2.4) as made:
        panels = zip(made.subplots(1, 2), ("033211", "044255"), ("up", "down"), "14", "35", strict=True)
        for ax, word, way, left, right in panels:
            orbit = solve_word(word, 1.6)
            assert orbit.points is not None
            draw_orbit(ax, Stadium(orbit.a), orbit.points, word)
            ax.set(title=f"{word}: runs go {way}", xlabel="", ylabel="", xticks=[], yticks=[])
            for x, y, text in (
                (0, 1.25, "2: top wall"),
                (0, -1.25, "0: bottom wall"),
                (-1.5, 0, f"{left}: left,\n{way}"),
                (1.6, 0, f"{right}: right,\n{way}"),
            ):
                ax.text(x, y, text, ha="center", va="center", color=GREY, fontsize=SMALL)
    save(made, folder / "figure.svg", "svg", "the six symbols of words")
    return (folder / "figure.svg").read_text(encoding="utf-8")


@dataclass(frozen=True)
class Figure:
    """A figure drawn by a command that ends with ``-o``, after other commands."""

    command: str
    before: tuple[str, ...] = ()

    def __call__(self, folder: Path) -> str:
        """Return the figure as SVG."""
        session, target = Session(folder), folder / "figure.svg"
        for each in self.before:
            session.command(each)
        target.unlink(missing_ok=True)
        said = session.command(f"{self.command} figure.svg")
        if not target.exists():
            raise SystemExit(said)
        return target.read_text(encoding="utf-8")


_CARD = 3.4, 3.0
"""Width and height, in inches, of a figure on a card of the first page, which is 250 pixels wide."""
CARD = f"--size {_CARD[0]}x{_CARD[1]} -o"


def card_of_deviations(folder: Path) -> str:
    """Draw `deviations` for a card."""
    from orbitdb.plots.style import sized

    with sized(_CARD):
        return deviations(folder)


LEVELS = "orbitdb levels --k 0:31.5"
"""Computes levels for half a minute."""


def assess(folder: Path) -> str:
    """Remove a twentieth of the levels from a list, and draw what `plot assess` finds missing."""
    import numpy as np

    from orbitdb import levels

    session, rng = Session(folder), np.random.default_rng(2)
    session.command("orbitdb fill --p 12 --a 1.8 --db judged.db")
    k = levels(1.8, 40, parity=["oo"]).k
    lost = rng.choice(len(k) - 8, len(k) // 20, replace=False)
    np.savetxt(folder / "measured.txt", np.delete(k, lost))
    return Figure("orbitdb plot assess --levels measured.txt --parity oo --a 1.8 --db judged.db -o")(folder)


def entropy_width(folder: Path) -> str:
    """Measure and draw the difference of the bounds on the entropy against time."""
    import numpy as np

    from orbitdb import Stadium
    from orbitdb.entropy_bounds.bounds import search
    from orbitdb.plots.style import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, figure, save

    def measured(a: float) -> tuple["np.ndarray", "np.ndarray"]:
        seconds, width, began = [], [], time.process_time()
        for bounds in search(Stadium(a)):
            seconds.append(time.process_time() - began)
            width.append(bounds.width)
            if 2 * seconds[-1] > SECONDS:
                break
        return np.array(seconds), np.array(width)

    with figure(6.4, 4.2) as made:
        ax = made.add_subplot()
        colours = (BLUE, ORANGE, GREEN, PURPLE, INK, GREY, BLUE)
        looks = zip(("o-", "s-", "^-", "D-", "v-", "x--", "+--"), colours, strict=True)
        for a, (look, colour) in zip((0.05, 0.2, 0.5, 1.0, 1.6, 3.0, 10.0), looks, strict=True):
            ax.loglog(*measured(a), look, color=colour, markersize=4, linewidth=1, label=f"$a = {a:g}$")
        ax.set(xlabel="time of one processor (s)", ylabel="upper bound - lower bound")
        ax.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    save(made, folder / "figure.svg", "svg", "width of the entropy bounds against time")
    return (folder / "figure.svg").read_text(encoding="utf-8")


DRAWN: dict[str, Callable[[Path], str]] = {
    "symbols.svg": symbols,
    "orbit.svg": Figure("orbitdb plot orbit 1232131 --a 1.2 -o"),
    "browse.svg": _screen(),
    "whole-orbit.svg": _screen("enter"),
    "counts.svg": _screen("d"),
    "columns.svg": _screen("asterisk", "j", "asterisk", "s", "end", "enter", "C"),
    "reverse.svg": Figure("orbitdb plot reverse --code 1232131 --a 1.2 -o"),
    "entropy.svg": Figure("orbitdb plot entropy -o"),
    "lyapunov.svg": Figure("orbitdb plot lyapunov -o"),
    "deviations.svg": deviations,
    "sheet.svg": Figure("orbitdb plot sheet --p 5 -o"),
    "card-sheet.svg": Figure(f"orbitdb plot sheet --p 5 --limit 8 {CARD}"),
    "card-deviations.svg": card_of_deviations,
    "card-spectrum.svg": Figure(f"orbitdb plot spectrum {CARD}", (LEVELS,)),
    "birkhoff.svg": Figure("orbitdb plot phase-space --p 2-5 -o"),
    "lengths.svg": Figure("orbitdb plot lengths --p 2-7 -o"),
    "life.svg": Figure("orbitdb plot life 010203113 -o"),
    "births.svg": Figure("orbitdb plot births --db births.db -o", ("orbitdb births --p 9 --db births.db",)),
    "symbol-plane.svg": Figure("orbitdb plot symbol-plane -o"),
    "pruning-fronts.svg": Figure("orbitdb plot symbol-plane --a 0.2 --a 0.5 --a 1.6 --a 5 --a 20 -o"),
    "spectrum.svg": Figure("orbitdb plot spectrum -o", (LEVELS,)),
    "staircase.svg": Figure("orbitdb plot staircase -o", (LEVELS,)),
    "assess.svg": assess,
    "spacings.svg": Figure("orbitdb plot spacings -o", (LEVELS,)),
    "rigidity.svg": Figure("orbitdb plot rigidity -o", (LEVELS,)),
    "wave.svg": Figure("orbitdb plot wave 13 --k 20.17 --parity ee -o"),
    "escape.svg": Figure("orbitdb plot escape --opening top:-0.3:0.3 -o"),
    "field.svg": Figure("orbitdb plot field 1232131 -o"),
    "husimi.svg": Figure("orbitdb plot husimi 13 --k 20.17 --parity ee -o"),
    "entropy-over-a.svg": Figure(
        "orbitdb plot entropy --over-a --db curve.db -o",
        ("orbitdb births --p 8 --db curve.db", "orbitdb bounds --a 0.2:10:25 --edges 10 --db curve.db"),
    ),
    "entropy-width.svg": entropy_width,
    "work-precision.svg": Figure("orbitdb bench -o"),
}
"""For every picture, the function that draws it as SVG from a folder with a catalogue."""

SCREENS = {"browse.svg", "whole-orbit.svg", "counts.svg", "columns.svg"}
"""The pictures of the terminal UI."""

ASKED = {
    "assess.svg": [
        "orbitdb fill --p 12 --a 1.8  # measured.txt: levels below k = 40, one in twenty removed",
        "orbitdb plot assess --levels measured.txt --parity oo --a 1.8 -o figure.svg",
    ],
}
"""Commands for figures in the gallery that are drawn by Python code here."""

CARDS = {"card-sheet.svg", "card-deviations.svg", "card-spectrum.svg"}
"""The pictures on the cards of the first page, drawn so small that their texts can be read there."""

GALLERY = [
    name for name, draw in DRAWN.items() if name in ASKED or (isinstance(draw, Figure) and name not in CARDS)
]
"""The pictures of the gallery, which commands can make."""


def commands(name: str) -> list[str]:
    """Return the commands that make a picture of the gallery."""
    draw = DRAWN[name]
    return [*draw.before, f"{draw.command} figure.svg"] if isinstance(draw, Figure) else ASKED[name]


MEASURED = {"work-precision.svg", "entropy-width.svg"}
"""The pictures that show measured times."""


def prepare(folder: Path, catalogue: Path | None = None) -> None:
    """Make the catalogue for the pictures, or copy a filled one, and add an average over trajectories."""
    if catalogue is None:
        Session(folder).command(FIRST_FILL)
    else:
        lay(catalogue, folder)
    Session(folder).command("orbitdb simulate --bounces 2000000")


def texts(svg: str) -> list[str]:
    """Return the texts in a picture: line by line for a terminal, in the order of the file for matplotlib."""
    svg = svg.replace("&#160;", " ")
    if "rich-terminal" not in svg:
        return re.findall(r"(?:<!-- |<text[^>]*>)(.*?)(?: -->|</text>)", svg)
    lines: dict[float, str] = {}
    for y, text in re.findall(r'<text [^>]*\by="([\d.]+)"[^>]*>([^<]*)</text>', svg):
        lines[float(y)] = lines.get(float(y), "") + text
    return [lines[y] for y in sorted(lines)]


def drawn_with(svg: str) -> str:
    """Return the version of matplotlib that a picture names as its source, or an empty string."""
    found = re.search(r"Matplotlib v[\d.]+", svg)
    return found[0] if found else ""


def main() -> None:
    """Draw the requested pictures."""
    parser = argparse.ArgumentParser(description="Draw the pictures of README.md and the pages.")
    parser.add_argument("names", nargs="*", choices=[*DRAWN, []], default=[], metavar="NAME")
    wanted = parser.parse_args().names or list(DRAWN)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary).resolve()
        prepare(folder)
        for name in wanted:
            (PICTURES / name).write_text(DRAWN[name](folder), encoding="utf-8")
            print(PICTURES / name, file=sys.stderr)


if __name__ == "__main__":
    main()
