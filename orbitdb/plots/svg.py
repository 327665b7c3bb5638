"""Orbits as SVG for notebooks and web pages, made with NumPy alone."""

import numpy as np

from orbitdb.arrays import Floats
from orbitdb.billiard.stadium import Stadium

Place = tuple[float, float]
"""Cartesian coordinates x and y."""

MOST_BOUNCES = 5000
_NUMBERED = 24
_PATH, _WALL, _FAINT, _PAPER = "#0072b2", "#333333", "#b8b8b8", "#ffffff"
_MARGIN = 0.3
_AWAY = 14
_NEAR = 0.12


def orbit_svg(stadium: Stadium, points: Floats, title: str, width: int = 480) -> str:
    """Return a picture of a closed path in its stadium, as one ``svg`` element.

    It shows the stadium with its continued walls and circles, the path with an arrow on its first link, and,
    if there are only a few bounces, a dot and a number for each.

    Parameters
    ----------
    points : ndarray, shape (p, 2)
        The bounces in order, in units of the radius.
    title : str
        Text alternative of the picture.
    width : int, optional
        Width in pixels.
    """
    scale = width / (2 * (stadium.a + 1 + _MARGIN))
    height = 2 * (1 + _MARGIN) * scale
    body = [_walls(stadium, scale, width), _path(points, scale)]
    if len(points) <= _NUMBERED:
        dots = "".join(f'<circle cx="{x:.2f}" cy="{y:.2f}" r="3.5"/>' for x, y in _pixels(points, scale))
        body += [f'<g fill="{_PATH}">{dots}</g>', *_numbers(stadium, points, scale)]
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height:.0f}" role="img"'
        f' viewBox="0 0 {width} {height:.2f}">',
        f"<title>{title}</title>",
        f'<rect width="{width}" height="{height:.2f}" fill="{_PAPER}"/>',
        f'<g transform="translate({width / 2:g} {height / 2:.2f})">',
        *body,
        "</g>",
        "</svg>",
    ])  # fmt: skip


def small_svg(stadium: Stadium, points: Floats, width: int = 150) -> str:
    """Return a small picture of a closed path in its stadium, without labels, as SVG.

    The parameters are those of `orbit_svg`.
    """
    scale = (width - 4) / (2 * (stadium.a + 1))
    height = 2 * scale + 4
    a, r = f"{stadium.a * scale:.2f}", f"{scale:.2f}"
    places = " ".join(f"{x:.2f},{y:.2f}" for x, y in _pixels(points, scale))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height:.0f}"'
        f' viewBox="{-width / 2:g} {-height / 2:.2f} {width} {height:.2f}">'
        f'<path d="{_outline(a, r)}" fill="{_PAPER}" stroke="{_WALL}"/>'
        f'<polygon points="{places}" fill="none" stroke="{_PATH}" stroke-linejoin="round"/></svg>'
    )


def _outline(a: str, r: str) -> str:
    return f"M-{a} {r}H{a}A{r} {r} 0 0 0 {a} -{r}H-{a}A{r} {r} 0 0 0 -{a} {r}Z"


def _walls(stadium: Stadium, scale: float, width: int) -> str:
    """Return the stadium and, faintly, its continued walls and circles as SVG, as in the paper's Fig. 1."""
    a, r = f"{stadium.a * scale:.2f}", f"{scale:.2f}"
    beyond = f"M{-width / 2:g} -{r}h{width}M{-width / 2:g} {r}h{width}"
    circles = f'<circle cx="-{a}" r="{r}"/><circle cx="{a}" r="{r}"/>'
    return (
        f'<g fill="none" stroke="{_FAINT}"><path d="{beyond}"/>{circles}</g>\n'
        f'<path d="{_outline(a, r)}" fill="none" stroke="{_WALL}" stroke-width="2"/>'
    )


def _path(points: Floats, scale: float) -> str:
    """Return the path as SVG, with an arrowhead in the middle of its first link."""
    places = " ".join(f"{x:.2f},{y:.2f}" for x, y in _pixels(points, scale))
    (x, y), (dx, dy) = (points[0] + points[1]) / 2 * scale, points[1] - points[0]
    turn = np.degrees(np.arctan2(-dy, dx))
    return (
        f'<polygon points="{places}" fill="none" stroke="{_PATH}" stroke-width="1.5"'
        ' stroke-linejoin="round"/>\n'
        f'<path d="M7 0L-5 5L-5 -5Z" fill="{_PATH}"'
        f' transform="translate({x:.2f} {-y:.2f}) rotate({turn:.2f})"/>'
    )


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


def _pixels(points: Floats, scale: float) -> list[tuple[float, float]]:
    return [(x * scale, -y * scale) for x, y in points.tolist()]


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
    labels = []
    for place, texts in places:
        x, y = place.tolist()
        middle = min(max(x, -stadium.a), stadium.a)
        labels.append(((x, y), (x - middle, y), ", ".join(texts)))
    return labels
