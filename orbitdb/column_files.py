"""Rows as blocks of columns, and the files that hold columns: parquet and npz, of any size.

An array in an npz file begins with its length, and a text array with the width of its longest text. Neither
is known before the last row has come, and all rows together may be larger than the memory: so each column
goes to a draft first.
"""

import json
import pickle
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from orbitdb.columns import kind_of
from orbitdb.errors import ExportError
from orbitdb.extras import load

if TYPE_CHECKING:
    import pyarrow as pa

_ROWS = 20_000
_LARGEST_TEXT = 2**31
_LEVEL = 3
"""Of compression: zlib's default takes three times the time for files that are a tenth smaller."""


@dataclass(frozen=True, eq=False)
class Lists:
    """A column of lists.

    Attributes
    ----------
    values : ndarray
        All of them, one list behind the other.
    lengths : ndarray of int64, shape (N,)
    present : ndarray of bool, shape (N,)
        Which rows have a list; one of length 0 is a list, too.
    """

    values: NDArray[Any]
    lengths: NDArray[np.int64]
    present: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.lengths)


Column = NDArray[np.float64] | Lists | Sequence[Any]
"""Numbers, NaN for none; lists; or any plain values, None for none."""


@dataclass(frozen=True, eq=False)
class ColumnBlock:
    """Some rows, column by column.

    Attributes
    ----------
    columns : sequence of Column
        Equally long.
    """

    columns: Sequence[Column]

    def __len__(self) -> int:
        return len(self.columns[0])

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Yield the rows as plain values, None for none."""
        return zip(*map(plain, self.columns), strict=True)


def plain(column: Column) -> Sequence[Any]:
    """Return a column as plain values, None for none."""
    if isinstance(column, Lists):
        parts = np.split(column.values, np.cumsum(column.lengths)[:-1])
        pairs = zip(parts, column.present.tolist(), strict=True)
        return [part.tolist() if present else None for part, present in pairs]
    if isinstance(column, np.ndarray):
        return [None if value != value else value for value in column.tolist()]
    return column


def in_columns(rows: Iterable[Any], size: int = _ROWS) -> Iterator[Sequence[Column]]:
    """Yield the columns of rows, so many at a time; rows may be blocks of columns, all of them or none."""
    rows = iter(rows)
    first = next(rows, None)
    if first is None:
        return
    rows = chain([first], rows)
    if isinstance(first, ColumnBlock):
        yield from (block.columns for block in rows)
        return
    while block := list(islice(rows, size)):
        yield list(zip(*block, strict=True))


def write_parquet(
    file: IO[bytes], columns: Sequence[str], rows: Iterable[Any], metadata: Mapping[str, Any]
) -> None:
    """Write typed columns, and each part of the metadata as JSON in that of the schema."""
    parquet = load("pyarrow.parquet", "a parquet file", "parquet")
    schema = arrow_schema(columns, metadata)
    with parquet.ParquetWriter(file, schema) as writer:
        for block in in_columns(rows):
            writer.write_batch(arrow_batch(block, schema))


def arrow_schema(columns: Sequence[str], metadata: Mapping[str, Any]) -> "pa.Schema":
    """Return the schema of some columns, with each part of the metadata as JSON."""
    import pyarrow as pa

    types = {
        "number": pa.float64(),
        "integer": pa.int64(),
        "text": pa.string(),
        "numbers": pa.list_(pa.float64()),
        "integers": pa.list_(pa.int64()),
    }
    notes = {name: json.dumps(value) for name, value in metadata.items()}
    return pa.schema([(name, types[kind_of(name)]) for name in columns], metadata=notes)


def arrow_batch(block: Sequence[Column], schema: "pa.Schema") -> "pa.RecordBatch":
    """Return columns of rows as a batch of Arrow."""
    import pyarrow as pa

    arrays = [_arrow(values, field.type) for values, field in zip(block, schema, strict=True)]
    return pa.record_batch(arrays, schema=schema)


def _arrow(values: Column, kind: "pa.DataType") -> "pa.Array":
    """Return a column as an Arrow array."""
    import pyarrow as pa

    if isinstance(values, Lists):
        starts = np.concatenate([[0], np.cumsum(values.lengths)]).astype(np.int32)
        return pa.ListArray.from_arrays(
            pa.array(starts), pa.array(values.values, kind.value_type), mask=pa.array(~values.present)
        )
    if isinstance(values, np.ndarray):
        return pa.array(values, type=kind, from_pandas=True)  # NaN is none
    return pa.array(values, type=kind)


def write_npz(
    file: IO[bytes], columns: Sequence[str], rows: Iterable[Any], metadata: Mapping[str, Any]
) -> None:
    """Write one array a column and ``metadata``, a text with JSON.

    Numbers that a row does not have are NaN, integers -1, texts empty. A column of lists is one flat
    array, and ``<name>_start`` says where each row begins in it and where the last one ends.

    Parameters
    ----------
    file : binary file
        Drafts of the columns are kept in its folder meanwhile.
    columns : sequence of str
    rows : iterable of sequences
        Plain Python values, lists or arrays; None where there is none. Or `ColumnBlock`s.
    metadata : mapping

    Raises
    ------
    ExportError
        If the texts would be too large.
    """
    with ExitStack() as open_drafts:

        def draft(name: str, dtype: DTypeLike) -> _Draft:
            return _Draft(name, dtype, open_drafts.enter_context(TemporaryFile(dir=Path(file.name).parent)))

        note = draft("metadata", np.str_)
        note.add_texts([json.dumps(dict(metadata))])
        drafts = [[draft(name, _DTYPES[kind_of(name)])] for name in columns]
        for own in drafts:
            if kind_of(own[0].name) in _LISTS:
                own.append(draft(f"{own[0].name}_start", np.int64))
                own[1].add(np.zeros(1, np.int64))
        for block in in_columns(rows):
            for own, values in zip(drafts, block, strict=True):
                _add(values, *own)
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive:
            note.write(archive, ())
            for each in chain.from_iterable(drafts):
                each.write(archive, (each.count,))


_LISTS = ("numbers", "integers")
_DTYPES = {
    "number": np.float64,
    "numbers": np.float64,
    "integer": np.int64,
    "integers": np.int64,
    "text": np.str_,
}


class _Draft:
    """An array in a file, part by part."""

    def __init__(self, name: str, dtype: DTypeLike, file: IO[bytes]) -> None:
        self.name, self.dtype, self.file = name, np.dtype(dtype), file
        self.parts = self.count = 0

    def add(self, part: "NDArray[Any] | list[str]") -> None:
        """Take further values."""
        pickle.dump(part, self.file)
        self.parts += 1
        self.count += len(part)

    def add_texts(self, texts: list[str]) -> None:
        """Take further texts, of which the longest says how wide all of them are."""
        width = max(1, self.dtype.itemsize // 4, *map(len, texts))
        if 4 * width * (self.count + len(texts)) > _LARGEST_TEXT:
            raise ExportError(
                f"npz makes every text as wide as the longest {self.name}, {width} characters: use parquet, "
                "or export fewer periods"
            )
        self.dtype = np.dtype(f"U{width}")
        self.add(texts)

    def write(self, archive: zipfile.ZipFile, shape: tuple[int, ...]) -> None:
        """Write the array."""
        head = {"descr": np.lib.format.dtype_to_descr(self.dtype), "fortran_order": False, "shape": shape}
        self.file.seek(0)
        with archive.open(f"{self.name}.npy", "w", force_zip64=True) as member:
            np.lib.format.write_array_header_1_0(member, head)
            for _ in range(self.parts):
                member.write(np.asarray(pickle.load(self.file), self.dtype).tobytes())


def _add(column: Column, values: _Draft, starts: _Draft | None = None) -> None:
    """Add a column to its draft; that of lists to two: their values, and where each ends."""
    if starts is not None:
        if not isinstance(column, Lists):
            lists = [() if each is None else each for each in column]
            lengths = np.array(list(map(len, lists)), np.int64)
            flat = np.concatenate([np.zeros(0, values.dtype), *lists])
            column = Lists(flat, lengths, lengths >= 0)
        starts.add(values.count + np.cumsum(column.lengths))
        values.add(column.values)
    elif values.dtype.kind == "U":
        values.add_texts([text or "" for text in plain(column)])
    elif isinstance(column, np.ndarray):
        values.add(column)
    else:
        missing = np.nan if values.dtype.kind == "f" else -1
        values.add(np.array([missing if value is None else value for value in plain(column)], values.dtype))
