"""Write rows as columns, to parquet and npz files."""

import json
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import IO, TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.arrays import Values
from orbitdb.column import Row
from orbitdb.columns import kind_of
from orbitdb.errors import ExportError
from orbitdb.extras import load

if TYPE_CHECKING:
    import pyarrow as pa

_ROWS = 20_000
_LARGEST_TEXT = 2**31
_LEVEL = 3
"""Compression level; zlib's default makes files a tenth smaller, but takes three times as long."""


def _in_columns(rows: Iterable[Row]) -> Iterator[list[Sequence[Any]]]:
    """Yield the rows as columns, one block of rows at a time."""
    rows = iter(rows)
    while block := list(islice(rows, _ROWS)):
        yield list(zip(*block, strict=True))


def write_parquet(
    file: IO[bytes],
    columns: Sequence[str],
    rows: Iterable[Row],
    metadata: Mapping[str, Any],
    compression: str = "snappy",
) -> int:
    """Write typed columns, with the metadata in the schema (`arrow_schema`); return the number of rows."""
    parquet = load("pyarrow.parquet", "a parquet file", "parquet")
    schema, count = arrow_schema(columns, metadata), 0
    with parquet.ParquetWriter(file, schema, compression=compression) as writer:
        for block in _in_columns(rows):
            writer.write_batch(arrow_batch(block, schema))
            count += len(block[0])
    return count


def arrow_schema(columns: Sequence[str], metadata: Mapping[str, Any]) -> "pa.Schema":
    """Return the Arrow schema of the named columns, with each part of the metadata as JSON."""
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


def arrow_batch(block: Sequence[Values], schema: "pa.Schema") -> "pa.RecordBatch":
    """Return columns as an Arrow record batch."""
    import pyarrow as pa

    arrays = [
        pa.array(values, type=field.type, from_pandas=isinstance(values, np.ndarray))  # NaN becomes null
        for values, field in zip(block, schema, strict=True)
    ]
    return pa.record_batch(arrays, schema=schema)


def write_npz(
    file: IO[bytes], columns: Sequence[str], rows: Iterable[Row], metadata: Mapping[str, Any]
) -> None:
    """Write one array per column, and an array ``metadata`` that contains a text in JSON.

    Missing numbers are NaN, missing integers -1, and missing texts empty. A column of lists is one flat
    array; ``<name>_start`` gives the index where each row begins in it, then the index where the last ends.

    Parameters
    ----------
    file : binary file
    columns : sequence of str
    rows : iterable of sequences
        Plain Python values, lists or arrays; None for a missing value.
    metadata : mapping

    Raises
    ------
    ExportError
        If an array of texts would be too large.
    """
    kept: list[list[Any]] = [[] for _ in columns]
    for block in _in_columns(rows):
        for known, values in zip(kept, block, strict=True):
            known += values
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive:

        def write(name: str, array: NDArray[Any]) -> None:
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, array)

        write("metadata", np.array(json.dumps(dict(metadata))))
        for name, values in zip(columns, kept, strict=True):
            if kind_of(name) not in _LISTS:
                write(name, _as_array(name, values))
                continue
            lists = [() if each is None else each for each in values]
            write(name, np.concatenate([np.zeros(0), *lists]).astype(_LISTS[kind_of(name)]))
            write(f"{name}_start", np.cumsum([0, *map(len, lists)]))


_LISTS = {"numbers": np.float64, "integers": np.int64}


def _as_array(name: str, values: Sequence[Any]) -> NDArray[Any]:
    """Return a column as an array with one value per row."""
    if kind_of(name) == "number":
        return np.array(values, np.float64)
    if kind_of(name) == "integer":
        return np.array([-1 if value is None else value for value in values], np.int64)
    texts = [text or "" for text in values]
    width = max(map(len, texts), default=0)
    if 4 * width * len(texts) > _LARGEST_TEXT:
        raise ExportError(
            f"npz makes every text as wide as the longest {name}, {width} characters: use parquet, "
            "or export fewer periods"
        )
    return np.array(texts, np.str_)
