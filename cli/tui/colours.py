"""Colours that can be read in every theme: text has enough contrast, and each curve its own ink."""

from collections.abc import Mapping, Sequence

from textual.color import BLACK, WHITE, Color

TEXT, _CLEAR = 4.5, 7.0
"""Least contrasts with the background: of any text (WCAG 2), and of text that is not muted."""

_INKS = {
    "one": "#e69f00", "two": "#3f9fe8", "three": "#2eb67d", "four": "#e0559a", "five": "#a884f0", "six": "#8a8a8a",
}  # fmt: skip
_ANSI_INKS = {"one": "yellow", "two": "blue", "three": "green", "four": "magenta", "five": "cyan"}
"""Hues of the inks, the same in every theme; the terminal chooses those of the ANSI themes."""

_GROUNDS = ("background", "surface", "panel")
_TEXTS = ("text-primary", "text-secondary", "text-warning", "text-error", "text-success", "text-accent")


def contrast(one: Color, other: Color) -> float:
    """Return the contrast ratio of two opaque colours, from 1 to 21, as WCAG 2 defines it."""
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


def _luminance(colour: Color) -> float:
    shares = (value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4 for value in colour.normalized)
    return sum(weight * share for weight, share in zip((0.2126, 0.7152, 0.0722), shares, strict=True))


def readable(colour: Color, grounds: Sequence[Color], least: float = TEXT) -> Color:
    """Blend a colour with black or white as little as gives it a contrast with all grounds."""

    def weakest(one: Color) -> float:
        return min(contrast(one, ground) for ground in grounds)

    end = max((BLACK, WHITE), key=weakest)
    blends = (colour.blend(end, step / 40) for step in range(41))
    return next((blend for blend in blends if weakest(blend) >= least), end)


def readable_variables(variables: Mapping[str, str]) -> dict[str, str]:
    """Return the CSS variables of a theme with readable colours, and those of our own."""
    if variables["background"].startswith("ansi"):
        inks = {f"ink-{name}": f"ansi_{hue}" for name, hue in _ANSI_INKS.items()}
        dim = {name: "ansi_bright_black" for name in ("muted", "ink-six")}
        return {**variables, **inks, **dim, "key": variables["accent"], "track": "ansi_bright_black"}
    background, *others = grounds = [Color.parse(variables[name]) for name in _GROUNDS]
    foreground = readable(Color.parse(variables["foreground"]), grounds, _CLEAR)
    muted = readable(foreground.blend(background, 0.5), grounds)
    cursor = Color.parse(variables["block-cursor-background"]).with_alpha(1)
    clear = {
        **{name: readable(Color.parse(variables[name]), grounds) for name in _TEXTS},
        **{f"ink-{name}": readable(Color.parse(hue), grounds) for name, hue in _INKS.items()},
        "foreground": foreground,
        "text": foreground,
        "muted": muted,
        "text-muted": muted,
        "text-disabled": muted,
        "key": readable(Color.parse(variables["accent"]), grounds),
        "track": background.blend(foreground, 0.3),
        "block-cursor-background": cursor,
        "block-cursor-foreground": WHITE if contrast(WHITE, cursor) >= TEXT else BLACK,
        "block-cursor-blurred-background": background.blend(cursor, 0.3),
        "block-cursor-blurred-foreground": readable(foreground, [background.blend(cursor, 0.3)]),
    }
    names = ("foreground", "description-foreground", "key-foreground")
    footer = dict(zip((f"footer-{name}" for name in names), (foreground, foreground, clear["key"]), strict=True))
    return {**variables, **{name: colour.hex for name, colour in (clear | footer).items()}}
