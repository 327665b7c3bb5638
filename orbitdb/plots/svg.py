"""Orbits as SVG for notebooks and web pages, made with NumPy alone."""

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium

Place = tuple[float, float]
"""Cartesian coordinates x and y."""

MOST_BOUNCES = 5000
_NUMBERED = 24
_PATH, _WALL, _FAINT, _PAPER = "#0072b2", "#333333", "#b8b8b8", "#ffffff"
_SMALL = 200
"""Narrower pictures, in pixels, show the stadium and the path alone."""
_MARGIN, _NARROW = 0.3, 0.04
"""Room around the stadium, in units of the radius, in a large and in a small picture."""
_AWAY = 14
_NEAR = 0.12


def orbit_svg(stadium: Stadium, points: Floats, title: str, width: int = 480) -> str:
    """Return a picture of a closed path in its stadium, as one ``svg`` element.

    It shows the stadium with its continued walls and circles, as in the paper's Fig. 1, the path with an
    arrow on its first link, and, if there are only a few bounces, a dot and a number for each.

    Parameters
    ----------
    points : ndarray, shape (p, 2)
        The bounces in order, in units of the radius.
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
    if not small and len(points) <= _NUMBERED:
        dots = (place.partition(",") for place in places)
        circles = "".join(f'<circle cx="{x}" cy="{y}" r="3.5"/>' for x, _, y in dots)
        body += [f'<g fill="{_PATH}">{circles}</g>', *_numbers(stadium, points, scale)]
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


def _numbers(stadium: Stadium, points: Floats, scale: float) -> list[str]:
    labels = [
        f'<text x="{x * scale + _AWAY * right:.2f}" y="{-y * scale - _AWAY * up:.2f}"'
        f' dy="0.35em">{text}</text>'
        for (x, y), (right, up), text in number_labels(stadium, points)
    ]
    return [
        f'<g fill="{_WALL}" font-family="sans-serif" font-size="13" text-anchor="middle"'
        f' stroke="{_PAPER}" stroke-width="4" paint-order="stroke">',
        *labels,
        "</g>",
    ]


def number_labels(stadium: Stadium, points: Floats) -> list[tuple[Place, Place, str]]:
    """Return labels that number the bounces from 1, given their points, shape (p, 2).

    A label consists of the point of a bounce, the outward direction at the wall there, and a text. Bounces
    that are close together share a label, such as ``2, 6``.
    """
    places: list[tuple[Floats, list[str]]] = []
    for n, point in enumerate(points):
        shared = [texts for place, texts in places if np.hypot(*(place - point)) < _NEAR]
        if shared:
            shared[0].append(str(n + 1))
        else:
            places.append((point, [str(n + 1)]))
    centres = [min(max(x, -stadium.a), stadium.a) for (x, _), _ in places]
    return [
        ((float(x), float(y)), (float(x) - centre, float(y)), ", ".join(texts))
        for ((x, y), texts), centre in zip(places, centres, strict=True)
    ]
