"""Orbits as SVG for notebooks and web pages, made with NumPy alone."""

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium

Place = tuple[float, float]
"""Cartesian coordinates x and y."""

MOST_BOUNCES = 5000
MOST_LABELLED = 24
"""Largest number of bounces that carry their symbols."""
_PATH, _WALL, _FAINT, _PAPER = "#0072b2", "#333333", "#b8b8b8", "#ffffff"
_SMALL = 200
"""Narrower pictures, in pixels, show the stadium and the path alone."""
_MARGIN, _NARROW = 0.3, 0.04
"""Room around the stadium, in units of the radius, in a large and in a small picture."""
_AWAY = 14
_NEAR = 0.12


def orbit_svg(stadium: Stadium, points: Floats, symbols: str, title: str, width: int = 480) -> str:
    """Return a picture of a closed path in its stadium, as one ``svg`` element.

    It shows the stadium with its continued walls and circles, as in the paper's Fig. 1, the path with an
    arrow on its first link, and, if there are only a few bounces, a dot and the symbol of each; the dot of
    the first is open.

    Parameters
    ----------
    points : ndarray, shape (p, 2)
        The bounces in order, in units of the radius.
    symbols : str
        The symbol of each bounce.
    title : str
        Text alternative of the picture.
    width : int, optional
        Width in pixels.
    """
    small = width < _SMALL
    room = _NARROW if small else _MARGIN
    scale = width / (2 * (stadium.a + 1 + room))
    height, a, r = 2 * (1 + room) * scale, f"{stadium.a * scale:.2f}", f"{scale:.2f}"
    places = [f"{x * scale:.2f},{-y * scale:.2f}" for x, y in points.tolist()]
    corner = f"{-width / 2:g}", f"{-height / 2:.2f}"
    body = [
        f'<path d="M-{a} {r}H{a}A{r} {r} 0 0 0 {a} -{r}H-{a}A{r} {r} 0 0 0 -{a} {r}Z" fill="none"'
        f' stroke="{_WALL}" stroke-width="{1 if small else 2}"/>',
        f'<polygon points="{" ".join(places)}" fill="none" stroke="{_PATH}"'
        f' stroke-width="{1 if small else 1.5}" stroke-linejoin="round"/>',
    ]
    if not small:
        walls = f"M{corner[0]} -{r}h{width}M{corner[0]} {r}h{width}"
        circles = f'<circle cx="-{a}" r="{r}"/><circle cx="{a}" r="{r}"/>'
        body.insert(0, f'<g fill="none" stroke="{_FAINT}"><path d="{walls}"/>{circles}</g>')
        body.append(_arrow(points, scale))
    if not small and len(points) <= MOST_LABELLED:
        dots = (place.partition(",") for place in places)
        circles = "".join(f'<circle cx="{x}" cy="{y}" r="3.5"/>' for x, _, y in dots)
        first = circles.replace("/>", f' fill="{_PAPER}" stroke="{_PATH}" stroke-width="1.5"/>', 1)
        body += [f'<g fill="{_PATH}">{first}</g>', *_symbols(stadium, points, symbols, scale)]
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height:.0f}" role="img"'
        f' viewBox="{corner[0]} {corner[1]} {width} {height:.2f}">',
        f"<title>{title}</title>",
        f'<rect x="{corner[0]}" y="{corner[1]}" width="{width}" height="{height:.2f}" fill="{_PAPER}"/>',
        *body,
        "</svg>",
    ])  # fmt: skip


def _arrow(points: Floats, scale: float) -> str:
    """Return an arrowhead in the middle of the first link."""
    (x, y), (dx, dy) = (points[0] + points[1]) / 2 * scale, points[1] - points[0]
    turn = np.degrees(np.arctan2(-dy, dx))
    place = f"translate({x:.2f} {-y:.2f}) rotate({turn:.2f})"
    return f'<path d="M7 0L-5 5L-5 -5Z" fill="{_PATH}" transform="{place}"/>'


def _symbols(stadium: Stadium, points: Floats, symbols: str, scale: float) -> list[str]:
    labels = [
        f'<text x="{x * scale + _AWAY * right:.2f}" y="{-y * scale - _AWAY * up:.2f}"'
        f' dy="0.35em">{text}</text>'
        for (x, y), (right, up), text in symbol_labels(stadium, points, symbols)
    ]
    return [
        f'<g fill="{_WALL}" font-family="sans-serif" font-size="13" text-anchor="middle"'
        f' stroke="{_PAPER}" stroke-width="4" paint-order="stroke">',
        *labels,
        "</g>",
    ]


def symbol_labels(stadium: Stadium, points: Floats, symbols: str) -> list[tuple[Place, Place, str]]:
    """Return labels with the symbols of bounces, given their points, shape (p, 2), in the same order.

    A label consists of the point of a bounce, the outward direction at the wall there, and a text. Bounces
    that are close together share a label; if their symbols differ, it is such as ``1, 4``.
    """
    places: list[tuple[Floats, list[str]]] = []
    for symbol, point in zip(symbols, points, strict=True):
        shared = [texts for place, texts in places if np.hypot(*(place - point)) < _NEAR]
        if not shared:
            places.append((point, [symbol]))
        elif symbol not in shared[0]:
            shared[0].append(symbol)
    centres = [min(max(x, -stadium.a), stadium.a) for (x, _), _ in places]
    return [
        ((float(x), float(y)), (float(x) - centre, float(y)), ", ".join(texts))
        for ((x, y), texts), centre in zip(places, centres, strict=True)
    ]
