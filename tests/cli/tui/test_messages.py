"""Messages and screenshots of Textual's own keys, and what an empty catalogue shows."""

from pathlib import Path

from screens import browsing, press, shown, until


def messages(app):
    return [(note.message, note.markup) for note in app._notifications]


async def test_a_screenshot_is_saved_here_without_a_folder_of_downloads(filled_once, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path / "nobody"))
    monkeypatch.setenv("XDG_DOWNLOAD_DIR", str(tmp_path / "nowhere"))
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "nothing"))
    async with browsing(filled_once) as (app, pilot):
        app.action_screenshot()
        await until(lambda: messages(app))
        [(message, markup)] = messages(app)
        assert message.startswith("Saved screenshot to [$text-success]")
        assert markup  # Textual's own messages keep their markup
        [file] = Path().glob("*.svg")
        assert "orbit" in file.read_text(encoding="utf-8")
        app.notify("a path with [brackets]")
        await press(pilot)
        assert messages(app)[-1] == ("a path with [brackets]", False)


async def test_an_empty_catalogue_shows_an_orbit_and_three_keys(tmp_path):
    async with browsing(tmp_path / "none.db", (120, 32)) as (app, pilot):
        text = shown(app)
        assert "1232131, 7 bounces, L = 22.4544, λ = 9.638" in text.replace("\N{NO-BREAK SPACE}", " ")
        assert all(key in text for key in ("f  fill the catalogue", "c  type a code", "?  all keys"))
        assert text.count("•") + text.count("◆") == 7
        await press(pilot, "c", *"13", "enter")
        assert "fill the catalogue" not in shown(app)
