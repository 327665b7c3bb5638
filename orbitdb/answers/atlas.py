"""An atlas: chosen orbits as one file that any browser opens, without the network (extra ``atlas``).

The data, Bokeh's scripts and the texts of the page are all in the file; ``atlas.js`` links its parts.
"""

import html
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from orbitdb.answers.dataset import CITE
from orbitdb.answers.subset import Subset
from orbitdb.billiard.stadium import Stadium
from orbitdb.display import load
from orbitdb.errors import InputError
from orbitdb.orbits.status import Status
from orbitdb.output_files import atomic_file
from orbitdb.selection import Selection
from orbitdb.symbols.plane import symbol_plane
from orbitdb.symbols.symmetry import members
from orbitdb.text import as_options, format_float, shell_line
from orbitdb.trajectories.pruning_front import Front, PruningFront

MOST = 50_000
"""Maximum number of classes in an atlas, so that browsers can hold it."""

_NUMBERS = (
    "length", "lyapunov", "lambda_d", "lambda_c", "margin", "area", "born", "p", "class_size", "walls",
    "maslov",
)  # fmt: skip
_ERRORS = ("length_error", "lyapunov_error", "lambda_c_error", "error", "area_error")
_TABLE = {
    "code": 130,
    "p": 40,
    "length": 95,
    "lyapunov": 90,
    "lambda_c": 80,
    "margin": 80,
    "time_reversal": 75,
}
"""The columns of the table, with their widths in pixels."""

_WALL, _PATH, _POINTS, _FRONT, _TEXT = "#808080", "#d1495b", "#1d8fa3", "#9a6fb5", "#808080"
"""Colours that can be seen on white and on black."""

_INPUT = ".bk-input { background-color: Canvas !important; color: CanvasText !important; }"
"""The style of fields, so that they follow the page into dark mode."""

_FINEST = 2**16 - 1
"""Steps from 0 to 1 in the symbol plane; more than a screen has take room in the file."""

_STEP = 1e-3
"""Distance in the symbol plane below which points of a front are drawn as one."""


def only_orbits(chosen: Sequence[Selection]) -> Selection:
    """Return the selection of the orbits among chosen words at one a; raise `InputError` for others."""
    if len(chosen) > 1:
        raise InputError("an atlas shows one stadium: choose one a")
    orbits = (Status.ORBIT,)
    if {*chosen[0].preferring(orbits).statuses} - {Status.ORBIT}:
        raise InputError("an atlas shows orbits: leave out the other statuses")
    return replace(chosen[0], statuses=orbits)


def atlas_command(page: Path, catalogue: str, chosen: Selection, order: str, limit: int | None) -> str:
    """Return the command that writes an atlas."""
    options = chosen.criteria() | {"order": order} | ({} if limit is None else {"limit": limit})
    return shell_line(["orbitdb", "export", page.name, "--db", catalogue, *as_options(options)])


def write_atlas(path: Path, subset: Subset, provenance: Mapping[str, Any]) -> int:
    """Write an atlas of classes of orbits, with their coordinates; return their number.

    Parameters
    ----------
    path : Path
    subset : Subset
        Classes of orbits, read with coordinates.
    provenance : mapping
        As in `Listing.provenance`.

    Raises
    ------
    InputError
        If there are too many classes.
    ModuleNotFoundError
        If Bokeh is not installed.
    """
    load("bokeh", "an atlas", "atlas")
    if len(subset) > MOST:
        raise InputError(f"an atlas has at most {MOST:,} classes, not {len(subset):,}: choose fewer")
    text = _page(subset, provenance)
    with atomic_file(path) as draft:
        draft.write_text(text, encoding="utf-8")
    return len(subset)


def _page(subset: Subset, provenance: Mapping[str, Any]) -> str:
    from bokeh.embed import file_html
    from bokeh.resources import INLINE

    told = {**provenance, "partial": ", ".join(map(str, provenance["partial"])) or "none", "cite": CITE}
    lines = (
        f"<dt>{html.escape(name)}</dt><dd>{html.escape(str(value))}</dd>" for name, value in told.items()
    )
    shown = {
        "heading": _title(subset),
        "count": f"{len(subset):,} symmetry classes. Click a row or a point; j and k, or the arrows, go on.",
        "provenance": "".join(lines),
        "metadata": json.dumps(dict(provenance)).replace("<", "\\u003c"),
    }
    return str(file_html(_document(subset), INLINE, template=_text("atlas.html"), template_variables=shown))


def _text(name: str) -> str:
    return (files(__package__) / "templates" / name).read_text(encoding="utf-8")


def _title(subset: Subset) -> str:
    return f"Periodic orbits of the stadium billiard, a = {format_float(subset.selection.a)}"


def _document(subset: Subset) -> Any:
    """Return the parts of the page, with the script that links them."""
    from bokeh.document import Document
    from bokeh.models import BooleanFilter, CDSView, ColumnDataSource, CustomJS

    sources = {name: ColumnDataSource(data) for name, data in (_stored(subset) | _DRAWN).items()}
    view = CDSView(filter=(kept := BooleanFilter()))
    charts, fields = _charts(subset, sources, view), _fields(subset)
    document = Document(title=_title(subset))
    for name, model in {**charts, **fields}.items():
        model.name = name
        document.add_root(model)
    linked = {
        **sources, **fields, "table": charts["table"], "scatter": charts["scatter"], "kept": kept,
        "half": subset.selection.a,
    }  # fmt: skip
    document.js_on_event("document_ready", CustomJS(args=linked, code=_text("atlas.js")))
    return document


_DRAWN: dict[str, dict[str, Any]] = {
    "path": {"x": [], "y": []},
    "symbols": {"x": [], "y": [], "symbol": []},
    "arrow": {"x": [], "y": [], "angle": []},
    "walls": {"gamma": [], "delta": []},
    "arcs": {"gamma": [], "delta": []},
}
"""What is drawn of the orbit that is shown; the script fills it."""


def _stored(subset: Subset) -> dict[str, dict[str, Any]]:
    """Return the columns of the classes, and of all their bounces, one orbit after the other."""
    orbits: dict[str, Any] = {name: np.asarray(getattr(subset, name)) for name in (*_NUMBERS, *_ERRORS)}
    orbits |= {name: getattr(subset, name).tolist() for name in ("code", "time_reversal", "symmetry")}
    orbits |= {
        "start": subset.start[:-1],
        "words": [" ".join(members(code)) for code in subset.code.tolist()],
    }
    plane = np.empty((int(subset.p.sum()), 2))
    for p in np.unique(subset.p).tolist():
        places = subset.start[:-1][subset.p == p][:, None] + np.arange(p)
        plane[places] = symbol_plane(subset.of_period(p)[0])
    gamma, delta = np.round(plane.T * _FINEST).astype(np.uint16)
    return {
        "orbits": orbits,
        "bounces": {"coordinate": subset.coordinates, "gamma": gamma, "delta": delta},
    }


def _charts(subset: Subset, sources: Mapping[str, Any], view: Any) -> dict[str, Any]:
    """Return the table and the pictures."""
    front = PruningFront(subset.selection.a)
    return {
        "table": _table(sources["orbits"], view),
        "picture": _picture(
            Stadium(subset.selection.a), *(sources[name] for name in ("path", "symbols", "arrow"))
        ),
        "scatter": _scatter(sources["orbits"], view),
        "walls": _plane(front.walls, sources["walls"], "bounces on walls"),
        "arcs": _plane(front.semicircles, sources["arcs"], "bounces on semicircles"),
    }


def _fields(subset: Subset) -> dict[str, Any]:
    """Return the facts of the orbit, and the fields in which one chooses rows and axes."""
    from bokeh.models import Div, Select, TextInput

    columns = [name for name in _NUMBERS if np.isfinite(getattr(subset, name).astype(float)).any()]
    periods = sorted({*map(str, subset.p.tolist())}, key=int)
    fields = {
        "sought": TextInput(placeholder="find a word, in any rotation", sizing_mode="stretch_width"),
        "period": Select(options=["every p", *periods], value="every p", width=100),
        "reversal": Select(options=["any reversal", "self", "pair"], value="any reversal", width=120),
        "abscissa": Select(title="across", options=columns, value="length", width=130),
        "ordinate": Select(title="up", options=columns, value="lambda_c", width=130),
    }
    for field in fields.values():
        field.stylesheets = [_INPUT]
    return {"facts": Div(sizing_mode="stretch_width"), **fields}


def _table(orbits: Any, view: Any) -> Any:
    from bokeh.models import DataTable, InlineStyleSheet, NumberFormatter, TableColumn

    titles = {"code": "word", "time_reversal": "reversal"}
    columns = [
        TableColumn(field=name, title=titles.get(name, name), width=width) for name, width in _TABLE.items()
    ]
    for column in columns:
        if column.field in _NUMBERS and column.field != "p":
            column.formatter = NumberFormatter(format="0.000000")
    style = InlineStyleSheet(css=_text("atlas-table.css"))
    return DataTable(
        source=orbits, view=view, columns=columns, index_position=None, sizing_mode="stretch_width",
        height=560, stylesheets=[style], autosize_mode="none", reorderable=False,
    )  # fmt: skip


def _figure(**options: Any) -> Any:
    """Return a figure without a background, so that it fits a light and a dark page."""
    from bokeh.plotting import figure

    made = figure(sizing_mode="stretch_width", background_fill_color=None, border_fill_color=None, **options)
    made.outline_line_color = None
    for axis in made.axis:
        axis.update(
            axis_label_text_color=_TEXT, major_label_text_color=_TEXT, axis_line_color=_TEXT,
            major_tick_line_color=_TEXT, minor_tick_line_color=None,
        )  # fmt: skip
    made.grid.grid_line_color, made.grid.grid_line_alpha = _WALL, 0.2
    return made


def _picture(stadium: Stadium, path: Any, symbols: Any, arrow: Any) -> Any:
    wide = 1.15 * (stadium.a + 1)
    made = _figure(
        aspect_ratio=wide / 1.25, max_height=320, match_aspect=True, toolbar_location=None,
        x_range=(-wide, wide), y_range=(-1.25, 1.25), tools="",
    )  # fmt: skip
    made.axis.visible = made.grid.visible = False
    made.line(*stadium.outline().T, color=_WALL, line_width=2)
    made.line("x", "y", source=path, color=_PATH, line_width=1.5)
    made.scatter("x", "y", source=path, color=_PATH, size=5)
    made.scatter("x", "y", angle="angle", source=arrow, color=_PATH, size=11, marker="triangle")
    made.text(
        "x", "y", text="symbol", source=symbols, text_color=_TEXT, text_align="center", text_baseline="middle"
    )
    return made


def _scatter(orbits: Any, view: Any) -> Any:
    from bokeh.models import HoverTool

    made = _figure(
        height=300, tools="pan,wheel_zoom,box_zoom,tap,reset", active_scroll="wheel_zoom",
        x_axis_label="length", y_axis_label="lambda_c",
    )  # fmt: skip
    made.scatter(
        "length", "lambda_c", source=orbits, view=view, size=5, color=_POINTS, alpha=0.5,
        selection_color=_PATH, selection_alpha=1, nonselection_alpha=0.4,
    )  # fmt: skip
    made.add_tools(HoverTool(tooltips=[("word", "@code"), ("p", "@p"), ("length", "@length{0.000000}")]))
    return made


def _plane(front: Front, points: Any, title: str) -> Any:
    """Draw one half of the symbol plane, with its front and the bounces of the orbit that is shown."""
    made = _figure(
        aspect_ratio=1, max_height=330, x_range=(0, 1), y_range=(0, 1), toolbar_location=None, tools="",
        title=title, x_axis_label="γ, future", y_axis_label="δ, past",
    )  # fmt: skip
    made.title.update(text_color=_TEXT, text_font_style="normal", text_font_size="12px")
    steps = np.round(np.stack([front.gamma, front.delta], axis=1) / _STEP) * _STEP
    steps = steps[np.concatenate([[True], (steps[1:] != steps[:-1]).any(axis=1)])]
    made.step(*steps.T, color=_FRONT, mode="after")
    made.step(*(1 - steps).T, color=_FRONT, mode="after")
    made.scatter("gamma", "delta", source=points, color=_PATH, size=6)
    return made
