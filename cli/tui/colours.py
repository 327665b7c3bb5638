"""Colours that can be read in every theme: text has enough contrast, and each curve its own ink."""

from collections.abc import Mapping, Sequence

from textual.color import BLACK, WHITE, Color

TEXT, _CLEAR = 4.5, 7.0
"""Least contrasts with the background: of any text (WCAG 2), and of text that is not muted."""

_INKS = {
    "one": "#e69f00", "two": "#3f9fe8", "three": "#2eb67d", "four": "#e0559a", "five": "#a884f0",
    "six": "#8a8a8a",
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
    linear = (x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4 for x in colour.normalized)
    return sum(weight * share for weight, share in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


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
        dim = dict.fromkeys(("muted", "ink-six", "track"), "ansi_bright_black")
        return {**variables, **inks, **dim, "key": variables["accent"]}
    grounds = [Color.parse(variables[name]) for name in _GROUNDS]
    background = grounds[0]
    foreground = readable(Color.parse(variables["foreground"]), grounds, _CLEAR)
    muted = readable(foreground.blend(background, 0.5), grounds)
    cursor = Color.parse(variables["block-cursor-background"]).with_alpha(1)
    beside = WHITE if contrast(WHITE, cursor) >= TEXT else BLACK
    key = readable(Color.parse(variables["accent"]), grounds)
    pale = background.blend(cursor, 0.3)
    clear = {
        **{name: readable(Color.parse(variables[name]), grounds) for name in _TEXTS},
        **{f"ink-{name}": readable(Color.parse(hue), [background]) for name, hue in _INKS.items()},
        **dict.fromkeys(
            ("foreground", "text", "footer-foreground", "footer-description-foreground"), foreground
        ),
        **dict.fromkeys(("muted", "text-muted", "text-disabled"), muted),
        **dict.fromkeys(("key", "footer-key-foreground"), key),
        **dict.fromkeys(("block-cursor-background", "input-selection-background"), cursor),
        **dict.fromkeys(("block-cursor-foreground", "input-selection-foreground"), beside),
        "block-cursor-blurred-background": pale,
        "block-cursor-blurred-foreground": readable(foreground, [pale]),
        "footer-background": grounds[-1],
        "track": background.blend(foreground, 0.3),
    }
    return {**variables, **{name: colour.hex for name, colour in clear.items()}}
