"""Certificates: proofs in ball arithmetic that the stored orbits are right."""

from collections.abc import Sequence

import sqlalchemy as sa

from orbitdb.store.writing.writer import Writer


def replace_certificates(
    writer: Writer,
    connection: sa.Connection,
    stadium_id: int,
    tried: Sequence[int],
    proved: Sequence[tuple[int, float, int]],
    version: str,
) -> None:
    """Store the certificates of the classes that were proved, and drop older ones of all that were tried.

    Parameters
    ----------
    writer : Writer
    connection : Connection
        Of the writer.
    stadium_id : int
    tried : sequence of int
        Numbers of classes.
    proved : sequence of (int, float, int)
        Class, radius, and bits of the arithmetic.
    version : str
        The program's.
    """
    keys = [(stadium_id, cycle) for cycle in tried]
    connection.exec_driver_sql("DELETE FROM certificate WHERE stadium = ? AND cycle = ?", keys)
    if proved:
        number = writer.run_id(connection)
        rows = [(stadium_id, cycle, radius, bits, version, number) for cycle, radius, bits in proved]
        connection.exec_driver_sql("INSERT INTO certificate VALUES (?, ?, ?, ?, ?, ?)", rows)
