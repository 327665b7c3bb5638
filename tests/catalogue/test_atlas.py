"""An atlas in a real browser: Chromium of the system, without a window. The tests are skipped without one."""

import json
import shlex
import shutil

import numpy as np
import pytest
from playwright.sync_api import sync_playwright
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.errors import ExportError, InputError
from orbitdb.symbols.symmetry import members

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-dev-shm-usage"]

needs_a_browser = pytest.mark.skipif(
    CHROMIUM is None, reason="NOT TESTED: the atlas needs Chromium; CONTRIBUTING.md says how to install it"
)


@pytest.fixture(scope="module")
def atlas(varied, tmp_path_factory):
    """An atlas of the orbits of a = 1.6."""
    path = tmp_path_factory.mktemp("atlas") / "atlas.html"
    return Catalogue(varied).atlas(path, a=1.6, p="2-6"), path


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield started
        started.close()


@pytest.fixture
def page(browser, atlas):
    """The atlas in a browser, with everything that it asked for and complained about."""
    opened = browser.new_page(viewport={"width": 1400, "height": 1100})
    requests, complaints = [], []
    opened.on("request", lambda request: requests.append(request.url))
    opened.on("pageerror", lambda error: complaints.append(str(error)))
    opened.on("console", lambda said: complaints.append(said.text) if said.type == "error" else None)
    opened.goto(atlas[1].as_uri())
    opened.wait_for_selector("body[data-ready]")
    yield opened
    assert requests == [atlas[1].as_uri()]  # nothing from the network
    assert complaints == []
    opened.close()


def model(page, name, what):
    """Return a value of the model of that name in the page."""
    return page.evaluate(f"Bokeh.documents[0].get_model_by_name({name!r}).{what}")


def shown(page):
    """Return the word whose facts are shown, and the points of its picture, shape (p + 1, 2)."""
    word = page.locator("#word").text_content()
    drawn = "renderers[1].data_source.data"
    points = [
        page.evaluate(f"[...Bokeh.documents[0].get_model_by_name('picture').{drawn}.{axis}]") for axis in "xy"
    ]
    return word, np.array(points).T


def check_shown(page, varied, word):
    """Check that the page shows a word: its path, its address and the bounds of its numbers."""
    found, points = shown(page)
    orbit = Catalogue(varied).orbit(word, a=1.6)
    assert found == word
    assert page.url.endswith(f"#{word}")
    assert np.abs(points - np.concatenate([orbit.points, there(orbit.points)[:1]])).max() < 1e-12
    facts = page.locator("h2#word + p").text_content()
    assert (
        f"L = {orbit.length:.13f} ± {orbit.length_error:.1e}".replace("e-0", "e-").replace("e+00", "e+0")
        in facts
    )


@pytest.mark.slow
@needs_a_browser
def test_a_row_and_keys_show_the_orbit_with_its_points(page, varied):
    rows = page.locator(".slick-row")
    for number in (3, 7):
        word = rows.nth(number).locator(".slick-cell").first.text_content()
        rows.nth(number).locator(".slick-cell").first.click()
        check_shown(page, varied, word)
    after = [rows.nth(number).locator(".slick-cell").first.text_content() for number in (8, 7, 6)]
    page.locator("h1").click()
    for key, word in zip(("j", "k", "ArrowUp"), after, strict=True):
        page.keyboard.press(key)
        check_shown(page, varied, word)


@pytest.mark.slow
@needs_a_browser
def test_filters_choose_rows_by_any_word_of_the_class(page, varied):
    def words():
        source = "Bokeh.documents[0].get_model_by_name('table')"
        return page.evaluate(
            f"[...Bokeh.index.find_one({source}).data.index].map(i => {source}.source.data.code[i])"
        )

    every = words()
    rows = Catalogue(varied).rows(
        a=1.6, p="2-6", status="orbit", classes=True, columns=("code", "time_reversal")
    )
    known = dict(map(tuple, rows))
    assert sorted(every) == sorted(known)
    page.get_by_placeholder("find a word").fill("2302")
    assert sorted(words()) == sorted(
        code for code in known if any("2302" in 2 * word and len(word) >= 4 for word in members(code))
    )
    page.get_by_placeholder("find a word").fill("")
    page.locator("select").nth(0).select_option("5")
    page.locator("select").nth(1).select_option("self")
    assert sorted(words()) == sorted(
        code for code, kind in known.items() if len(code) == 5 and kind == "self"
    )


@pytest.mark.slow
@needs_a_browser
def test_the_address_names_a_word_and_the_axes_any_two_columns(page, varied):
    for asked, word in (("1320", "0132"), ("31", "13")):
        page.evaluate(f"location.hash = '{asked}'")
        page.wait_for_function(f"location.hash === '#{word}'")
        check_shown(page, varied, word)
    page.locator("select").nth(2).select_option("margin")
    assert model(page, "scatter", "below[0].axis_label") == "margin"
    assert model(page, "scatter", "renderers[0].glyph.x.field") == "margin"
    low, high = (model(page, "scatter", f"x_range.{end}") for end in ("start", "end"))
    margins = Catalogue(varied).select(a=1.6, p="2-6").margin
    assert low < margins.min() < margins.max() < high < margins.max() + 0.5


@pytest.mark.slow
def test_an_atlas_says_where_it_comes_from(atlas, varied, cli, tmp_path, monkeypatch):
    def provenance(text):
        return json.loads(text.partition('id="provenance">')[2].partition("</script>")[0])

    count, path = atlas
    text = path.read_text(encoding="utf-8")
    found = provenance(text)
    assert count == Catalogue(varied).count(a=1.6, p="2-6", status="orbit", by=[])["classes"][0]
    assert found["selection"].endswith("orbits of period 2 to 6 at a = 1.6")
    assert found["database"] == str(varied.resolve())
    assert {run["orbitdb"] for run in found["made_by"]} == {found["orbitdb"]}
    assert "no authors' names" in text.replace("&#x27;", "'")
    (folder := tmp_path / "again").mkdir()
    monkeypatch.chdir(folder)
    assert cli(*shlex.split(found["command"])[1:]).code == 0
    again = provenance((folder / "atlas.html").read_text(encoding="utf-8"))
    assert {**again, "date": None} == {**found, "date": None}
    with pytest.raises(ExportError):
        Catalogue(varied).atlas(path, a=1.6)
    assert Catalogue(varied).atlas(path, a=1.6, where="p > 50", force=True) == 0
    assert path.read_text(encoding="utf-8") == text
    for wrong, told in ({"a": [1.0, 1.6]}, "one a"), ({"a": 1.6, "status": "dynamical"}, "shows orbits"):
        with pytest.raises(InputError, match=told):
            Catalogue(varied).atlas(tmp_path / "x.html", **wrong)
    assert list(tmp_path.iterdir()) == [folder]


@pytest.mark.slow
def test_the_command_writes_an_atlas_and_refuses_what_it_cannot_show(cli, own, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = cli("export", "small.html", "--a", "1.6", "--p", "3")
    assert done.code == 0
    assert "2 classes written: classes of orbits of period 3 at a = 1.6, in small.html" in done.err
    again = cli("export", "small.html", "--a", "1.6", "--p", "3")
    assert again.says(2, "small.html", "--force")
    for where in ("rules is null", "status = 'orbit'"):  # which elsewhere mean every status
        assert cli("export", "small.html", "--a", "1.6", "--p", "3", "--where", where, "-f").code == 0
    none = cli("export", "none.html", "--a", "1.6", "--where", "p > 50")
    assert (none.code, "nothing is written" in none.err) == (1, True)
    assert cli("export", "x.html", "--columns", "code").says(2, "--columns does nothing with x.html")
    assert {path.name for path in tmp_path.iterdir() if path.suffix == ".html"} == {"small.html"}
