"""Words followed into a magnetic field, and their bounces as starts of the independent map."""

import numpy as np
from field_map import Floats, State
from solutions import solved, words_of

from orbitdb.arrays import Words
from orbitdb.billiard.stadium import Stadium
from orbitdb.magnetic.action import ArcPaths
from orbitdb.magnetic.along_kappa import FollowedWords, follow_in_field
from orbitdb.magnetic.field_status import IN_FIELD, FieldNumbers, measure

A = 1.6


def paths_at(words: Words, places: Floats, kappa: float, a: float = A) -> ArcPaths:
    """Join bounces, shape (N, p), by arcs of one curvature."""
    return ArcPaths.of(Stadium(a), words.T, places.T, np.full(len(words), kappa))


def followed(p: int, kappa: float, a: float = A) -> tuple[Words, Floats]:
    """Return all words of a period and their bounces at a curvature, each of shape (N, p)."""
    words, orbits = words_of(p), solved(p, a)
    zero = np.zeros(len(words))
    return words, follow_in_field(Stadium(a), words, orbits.coordinates, zero, zero + kappa).coordinates


def measured(words: Words, places: Floats, kappa: float, a: float = A) -> FieldNumbers:
    """Return the statuses and numbers of words with given bounces, shape (N, p)."""
    found = FollowedWords(places, paths_at(words, places, kappa, a).residuals)
    return measure(Stadium(a), words, found, np.full(len(words), kappa))


def orbits_at(p: int, kappa: float, a: float = A) -> tuple[Words, Floats]:
    """Return the words of a period that are orbits at a curvature, and their bounces, each (N, p)."""
    words, places = followed(p, kappa, a)
    real = np.isin(measured(words, places, kappa, a).status, IN_FIELD)
    return words[real], places[real]


def states(words: Words, places: Floats, kappa: float, a: float = A) -> State:
    """Return the bounces of paths as starts of the map, each of shape (N, p)."""
    points = Stadium(a).points(words, places)
    chord = np.roll(points, -1, axis=1) - points
    size = np.hypot(chord[..., 0], chord[..., 1])
    angle = np.arctan2(chord[..., 1], chord[..., 0]) - np.arcsin(kappa * size / 2)
    return State(points[..., 0], points[..., 1], angle, np.array([0, 1, 2, 3, 1, 3])[words])
