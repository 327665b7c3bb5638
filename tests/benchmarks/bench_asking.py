"""What is asked of a large catalogue: processor time and memory of whole commands, one after the other.

Run it as ``python tests/benchmarks/bench_asking.py DATABASE [asking | exports | verify] [OPTIONS ...]`` with
orbitdb installed, on Linux or macOS; options such as ``--p 13`` go to every command. Processor time counts
all processes of a command, memory is that of the largest one.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

MAIN = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()"]
MEGABYTE = 1e6 if sys.platform == "darwin" else 1e6 / 1024
"""Of memory, in what the system counts it."""

FIRST = ["query", "--json", "--limit", "40"]
ASKING = {
    "in the order of the table": FIRST,
    "behind 8 000 000 others": [*FIRST, "--offset", "8000000"],
    "orbits behind 3 000 000": [*FIRST, "--offset", "3000000", "--status", "orbit"],
    "--contains, rare": [*FIRST, "--contains", "11111113444444"],
    "--contains, rare, by length": [*FIRST, "--contains", "11111113444444", "--order", "length"],
    "--contains, behind 3 000 000": [*FIRST, "--contains", "13", "--offset", "3000000"],
    "--contains, by length": [*FIRST, "--contains", "0123", "--order", "length"],
    "--where element": [*FIRST, "--where", "element = 7"],
    "--where element, by lambda_c": [*FIRST, "--where", "element = 7", "--order", "lambda_c"],
    "--where code like": [*FIRST, "--where", "code like '%31'"],
    "--where of word and class": [
        *FIRST, "--where", "element = 3 and lambda_c < 0.38", "--order", "length desc",
    ],
    "by lambda_c": [*FIRST, "--order", "lambda_c"],
    "by length behind 1 000 000": [*FIRST, "--order", "length", "--offset", "1000000"],
    "by code": [*FIRST, "--order", "code"],
    "by status": [*FIRST, "--order", "status"],
    "by element": [*FIRST, "--order", "element desc"],
    "how many contain 13": ["query", "--contains", "13"],
    "how many orbits end with 31": ["query", "--where", "code like '%31'", "--status", "orbit"],
}  # fmt: skip
EXPORTS = {
    "csv": ["export", "all.csv"],
    "jsonl": ["export", "all.jsonl"],
    "json": ["query", "--json"],
    "parquet": ["export", "all.parquet"],
    "npz with coordinates of orbits": ["export", "orbits.npz", "--status", "orbit", "--coordinates"],
}
VERIFY = {"one process": ["verify", "--jobs", "1"], "two processes": ["verify", "--jobs", "2"]}
PARTS = {"asking": ASKING, "exports": EXPORTS, "verify": VERIFY}


def measure(command: list[str], folder: str) -> tuple[float, float]:
    """Return the processor time in seconds and the memory in MB of a command."""
    process = subprocess.Popen(
        [*MAIN, *command], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    _, status, used = os.wait4(process.pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, command
    return used.ru_utime + used.ru_stime, used.ru_maxrss / MEGABYTE


def main() -> None:
    database, *rest = sys.argv[1:]
    part, *options = rest or ["asking"]
    for name, command in PARTS[part].items():
        with tempfile.TemporaryDirectory() as folder:
            seconds, memory = measure([*command, *options, "--db", str(Path(database).resolve())], folder)
        print(f"{name:32} {seconds:7.1f} s {memory:6.0f} MB", flush=True)


if __name__ == "__main__":
    main()
