"""Npz files of any size: rows go to drafts of their columns first, which are told when they are complete.

An array in such a file begins with its length, and a text array with the width of its longest text. Neither
is known before the last row has come, and all rows together may be larger than the memory.
"""

import json
import marshal
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from orbitdb.column_blocks import Lists, in_columns
from orbitdb.columns import kind_of
from orbitdb.errors import ExportError

_BLOCK = 20_000
_LARGEST_TEXT = 2**31
_LEVEL = 3
"""Of compression: zlib's default takes three times the time for files that are a tenth smaller."""


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
    with ExitStack() as drafts:
        folder = Path(file.name).parent
        kept = [
            _KINDS[kind_of(name)](name, drafts.enter_context(TemporaryFile(dir=folder))) for name in columns
        ]
        for block in in_columns(rows):
            for column, values in zip(kept, block, strict=True):
                column.add(values)
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as archive:
            note = np.array(json.dumps(dict(metadata)))
            _write_array(archive, "metadata", note.dtype, (), [note])
            for column in kept:
                column.write(archive)


def _write_array(
    archive: zipfile.ZipFile,
    name: str,
    dtype: np.dtype[Any],
    shape: tuple[int, ...],
    parts: Iterable[NDArray[Any]],
) -> None:
    """Write an array piece by piece."""
    head = {"descr": np.lib.format.dtype_to_descr(dtype), "fortran_order": False, "shape": shape}
    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
        np.lib.format.write_array_header_1_0(member, head)
        for part in parts:
            member.write(np.asarray(part, dtype).tobytes())


class _Numbers:
    """A column of numbers, or of integers, in a draft."""

    dtype: np.dtype[Any] = np.dtype(np.float64)
    missing: float = np.nan

    def __init__(self, name: str, draft: IO[bytes]) -> None:
        self.name, self.draft, self.count = name, draft, 0

    def add(self, values: Any) -> None:
        """Take the values of further rows (`orbitdb.column_blocks.Column`)."""
        if not isinstance(values, np.ndarray):
            values = np.array([self.missing if value is None else value for value in values], self.dtype)
        self._keep(values.astype(self.dtype, copy=False))

    def _keep(self, array: NDArray[Any]) -> None:
        self.draft.write(array.tobytes())
        self.count += len(array)

    def write(self, archive: zipfile.ZipFile) -> None:
        """Write the array."""
        _write_array(archive, self.name, self.dtype, (self.count,), self._parts())

    def _parts(self) -> Iterator[NDArray[Any]]:
        self.draft.seek(0)
        while data := self.draft.read(_BLOCK * self.dtype.itemsize):
            yield np.frombuffer(data, self.dtype)


class _Integers(_Numbers):
    dtype, missing = np.dtype(np.int64), -1


class _Lists(_Numbers):
    """A column of lists: one behind the other, and where they begin."""

    def __init__(self, name: str, draft: IO[bytes]) -> None:
        super().__init__(name, draft)
        self.lengths: list[NDArray[np.int64]] = []

    def add(self, values: Any) -> None:
        """Take the values of further rows."""
        if isinstance(values, Lists):
            self.lengths.append(values.lengths)
            self._keep(values.values.astype(self.dtype, copy=False))
            return
        lists = [() if value is None else value for value in values]
        self.lengths.append(np.array(list(map(len, lists)), np.int64))
        self._keep(np.concatenate([np.zeros(0, self.dtype), *lists]).astype(self.dtype))

    def write(self, archive: zipfile.ZipFile) -> None:
        """Write both arrays."""
        super().write(archive)
        ends = np.cumsum(np.concatenate([np.zeros(1, np.int64), *self.lengths]), dtype=np.int64)
        _write_array(archive, f"{self.name}_start", ends.dtype, ends.shape, [ends])


class _IntegerLists(_Lists):
    dtype = np.dtype(np.int64)


class _Texts(_Numbers):
    """A column of texts: an array of fixed width, the only kind that npz has."""

    width = 1

    def add(self, values: Any) -> None:
        """Take the values of further rows."""
        texts = [value or "" for value in values]
        self.width = max(self.width, *map(len, texts))
        self.count += len(values)
        if 4 * self.width * self.count > _LARGEST_TEXT:
            raise ExportError(
                f"npz holds all texts as wide as the longest {self.name}, of {self.width}: use parquet, or "
                "fewer periods"
            )
        marshal.dump(texts, self.draft)

    def write(self, archive: zipfile.ZipFile) -> None:
        """Write the array."""
        self.dtype = np.dtype(f"U{self.width}")
        super().write(archive)

    def _parts(self) -> Iterator[NDArray[Any]]:
        end = self.draft.tell()
        self.draft.seek(0)
        while self.draft.tell() < end:
            yield np.array(marshal.load(self.draft), self.dtype)


_KINDS = {
    "number": _Numbers,
    "integer": _Integers,
    "text": _Texts,
    "numbers": _Lists,
    "integers": _IntegerLists,
}
