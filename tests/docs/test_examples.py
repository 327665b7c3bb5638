"""README and pages show what their examples really print."""

import re
from importlib.metadata import version
from pathlib import Path

import console
import pages
import pictures
import pytest

SCREENSHOTS_OF = "8.2"
"""The version of Textual that took the screenshots; others may draw borders differently."""


LONG = dict.fromkeys(
    (
        "assess.svg",
        "births.svg",
        "card-deviations.svg",
        "card-spectrum.svg",
        "deviations.svg",
        "entropy-over-a.svg",
        "escape.svg",
        "husimi.svg",
        "rigidity.svg",
        "spacings.svg",
        "spectrum.svg",
        "staircase.svg",
    ),
    "fuzz",
)
"""Pictures that take too long for CI."""


@pytest.fixture(scope="session")
def catalogue(tmp_path_factory) -> Path:
    return console.first_catalogue(tmp_path_factory.mktemp("pages"))


@pytest.fixture(scope="session")
def studio(tmp_path_factory, catalogue) -> Path:
    """The folder that pictures are drawn in."""
    folder = tmp_path_factory.mktemp("studio")
    pictures.prepare(folder, catalogue)
    return folder


def run(page: Path, folder: Path, catalogue: Path) -> list[tuple[pages.Example, str]]:
    """Run the examples of a page; return each with its output."""
    wanted = pages.examples(page)
    session = console.begin(wanted, folder, catalogue)
    return [(example, session.run(example)) for example in wanted]


def wrong(outputs: list[tuple[pages.Example, str]]) -> str:
    """Return the examples whose page differs from their output, with that output.

    To correct the pages, run ``python docs/console.py --write``.
    """
    differing = [(each, output) for each, output in outputs if not each.holds(output)]
    return "\n\n".join(f"{each.line}: {each.source}\n{output}" for each, output in differing)


def named(page: Path) -> str:
    return page.stem


@pytest.mark.slow
@pytest.mark.parametrize("page", pages.PAGES, ids=named)
def test_the_examples_of_a_page_show_their_output(page, tmp_path, catalogue):
    assert wrong(run(page, tmp_path, catalogue)) == ""


PAGE = """
```console
$ orbitdb query --code 1232131 --json | grep '"length"' | wc -l
1

$ orbitdb entropy --p 2-3 --format csv -c
orbitdb: No such option: -c (--help shows the options)
```

```python
from orbitdb import Catalogue
print("lyapunov", Catalogue()["1232131"].lyapunov)
```

```text
lyapunov 9.6478825
```

<!-- not run: it installs -->
```console
pip install .
```
"""


@pytest.mark.slow
def test_a_wrong_example_is_found_and_corrected(tmp_path, catalogue):
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    outputs = run(page, tmp_path, catalogue)
    assert wrong(outputs) == f"11: {pages.examples(page)[2].source}\nlyapunov 9.637918173875862"
    console.rewrite(page, outputs)
    assert page.read_text() == PAGE.replace("9.6478825", "9.637918173875862")


def test_an_unrunnable_example_says_why(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(PAGE.replace("<!-- not run: it installs -->", ""))
    with pytest.raises(ValueError, match=r"page.md:20: mark this block as"):
        pages.examples(page)


@pytest.mark.parametrize(
    ("shown", "output", "agree"),
    [
        ("p = 2..7: 685 orbits, 0.1 s", "p = 2..7: 685 orbits, 32 s", True),
        ("p = 2..7: 685 orbits, 0.1 s", "p = 2..7: 686 orbits, 0.1 s", False),
        ("lyapunov 9.63791817 +- 3.1e-14", "lyapunov 9.63791818 +- 3.0e-14", True),
        ("lyapunov 9.63791817 +- 3e-14", "lyapunov 9.63791818 +- 1e-14", False),
        ("lyapunov 9.63791817 +- 3e-14", "lyapunov 9.63791917 +- 3e-14", False),
        ("lambda_d = 0.88690 +- 0.00021", "lambda_d = 0.88731 +- 0.00020", True),
        ("residual 1.1e-16", "residual  0.0e+00", True),
        ("01023,12.447620830852916", "01023,12.447620830852918", True),
        ("01023,12.447620830852916", "01032,12.447620830852916", False),
        ("no orbit", "no orbit\nmore", False),
        ("p  a, 0.1 s", "p  a, 0.25 s", True),
        ("p   a", "p  a", False),
    ],
)
def test_outputs_agree_up_to_times_and_errors(shown, output, agree):
    assert pages.same(shown, output) is agree


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=getattr(pytest.mark, LONG.get(name, "slow")))
        for name in sorted(set(pictures.DRAWN) - pictures.MEASURED)
    ],
)
def test_a_picture_is_what_the_code_draws(name, studio):
    kept = (pictures.PICTURES / name).read_text(encoding="utf-8")
    if name in pictures.SCREENS and not version("textual").startswith(SCREENSHOTS_OF):
        pytest.skip("taken with another Textual")
    drawn = pictures.DRAWN[name](studio)
    assert pages.same("\n".join(pictures.texts(kept)), "\n".join(pictures.texts(drawn)))
    if pictures.drawn_with(kept) == pictures.drawn_with(drawn):
        same = pages.same(numbered(kept), numbered(drawn))
        assert same, f"python docs/pictures.py {name} draws it anew"


def numbered(svg):
    """Number the generated names of clip paths and markers, which are hashes of all coordinates."""
    names = dict.fromkeys(re.findall(r'\bid="([pm][0-9a-f]{10})"', svg))
    for number, name in enumerate(names):
        svg = re.sub(rf"\b{name}\b", f"name {number}", svg)
    return svg


@pytest.mark.slow
def test_the_measured_picture_has_the_current_methods(studio):
    def said(svg: str) -> list[str]:
        kept = (text for text in pictures.texts(svg) if not re.search("mathdefault|p = ", text))
        return sorted(re.sub(r"\^\{-[0-9]+\}", "", text) for text in kept)  # how far it goes depends on p

    console.Session(studio).command("orbitdb bench --p 3 -o work.svg")
    kept = (pictures.PICTURES / "work-precision.svg").read_text(encoding="utf-8")
    assert said(kept) == said((studio / "work.svg").read_text(encoding="utf-8"))
