"""Commands run one after another, and every word they write.

Each file in ``sessions`` has a command after ``$``, then its stdout, its stderr after ``!``, and its exit
code in brackets unless it is 0. In those named for refusals, each command says in one line what is wrong,
and changes nothing. To rewrite them, and then review the changes, run
``ORBITDB_WRITE_SNAPSHOTS=1 pytest -n 0 -m '' tests/cli/test_sessions.py``.
"""

import io
import os
import re
import shlex
import shutil
from pathlib import Path

import pytest
from quick import slow_but

SESSIONS = {path.stem: path for path in sorted((Path(__file__).parent / "sessions").glob("*.txt"))}
FROM_NOTHING = {"storing", "bounds"}
"""The other sessions use the varied catalogue."""

CHANGES = [
    (r"\b\d+\.\d+ s\b", "0.1 s"),
    (r"\b\d+ [kM]B\b", "9 kB"),
    (r"(\n(?:length|lyapunov) .*\.\d{1,6})\d* \+- .*", r"\1 +- bound"),
    (r"(\n(?:residual|error)  +).*", r"\1small"),
]
"""Texts that change with every run, or whose last digits depend on the machine."""


@pytest.mark.parametrize("name", slow_but(["storing"], SESSIONS))
def test_a_session_has_not_changed(name, cli, tmp_path, monkeypatch, request):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdin", io.StringIO())
    session, own, refuses = SESSIONS[name], tmp_path / "orbits.db", "refusals" in name
    if name not in FROM_NOTHING:
        shutil.copy(request.getfixturevalue("varied"), own)
    content = own.read_bytes() if refuses else b""
    before = session.read_text(encoding="utf-8")
    blocks = []
    for line in before.splitlines():
        if line.startswith("$ "):
            found = cli(*shlex.split(line)[2:])
            if refuses:
                assert found.code, line
                noted = (
                    re.sub(r"(?m)^a = 1\.6, of 2 values in .*\n", "", found.err)
                    if found.code == 1
                    else found.err
                )
                assert found._replace(err=noted).says(found.code, "" if found.code == 1 else "orbitdb: "), (
                    line,
                    found,
                )
                assert own.read_bytes() == content, line
            text = found.out + "".join(f"! {said}\n" for said in found.err.splitlines())
            text += f"[{found.code}]\n" if found.code else ""
            for pattern, same in [(re.escape(str(tmp_path)), "HERE"), *CHANGES]:
                text = re.sub(pattern, same, text)
            blocks.append(f"{line}\n{text}")
    after = "".join(blocks)
    if refuses:
        assert {path.name.partition("-")[0] for path in tmp_path.iterdir()} == {own.name}  # and its journal
    if os.environ.get("ORBITDB_WRITE_SNAPSHOTS"):
        session.write_text(after, encoding="utf-8")
    assert after.split("\n$ ") == before.split("\n$ ")
