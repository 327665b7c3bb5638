"""The screen in a browser: pages served, access, and how it ends."""

import asyncio
import json
import re
import signal
import socket
import sys
from contextlib import suppress
from typing import Any

import pytest
from processes import kill_group, nobody_left, start
from there import there

from orbitdb.catalogue import Catalogue
from orbitdb.store.asking.selection import Selection

_ESCAPE = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|[@-_])")


async def seen(socket, text):
    """Read a session's output until a text appears."""
    drawn = ""
    async with asyncio.timeout(60):
        while text not in _ESCAPE.sub("", drawn):
            message = await socket.receive()
            assert isinstance(message.data, bytes), message
            drawn += message.data.decode("utf-8", "replace")


async def ended(socket):
    """Read a session's output until the server closes it."""
    async with asyncio.timeout(60):
        while not socket.closed:
            await socket.receive()


@pytest.mark.slow
def test_the_screen_is_served_with_its_options_to_holders_of_the_token(filled_once):
    aiohttp = pytest.importorskip("aiohttp")  # here, because importing it takes as long as ten tests
    chosen = Selection(time_reversal="self", periods=((2, 4),))
    where = "time_reversal = 'self' and p < :top"
    asked = ("--port", "0", "--db", filled_once, "--where", where, "-P", "top=5", "--a", "1.6")
    served = start("browse", "--web", *asked)
    page, _, rest = there(served.stderr).readline().removeprefix("open ").partition(" ")
    base = page.rpartition("/")[0].rpartition("/")[0]

    async def visit():
        async with aiohttp.ClientSession() as session:
            for path in ("/", "/ws", "/static/js/textual.js", f"/{'0' * 32}/", "/\xff", "//"):
                async with session.get(base + path) as refused:
                    assert refused.status == 403
            with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                await session.ws_connect(f"{base}/ws")
            for other in (page.replace("127.0.0.1", "localhost"), page.rstrip("/")):
                async with session.get(other) as answer:
                    assert (answer.status, str(answer.url)) == (200, page)
            async with session.get(f"{page}ws") as refused:
                assert refused.status == 400
            for origin in ("http://127.0.0.1:1", "http://localhost", "null"):
                with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                    await session.ws_connect(f"{page}ws", origin=origin)
            assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
            async with session.ws_connect(f"{page}ws?width=120&height=30") as keys:
                await seen(keys, f"1 of {Catalogue(filled_once).count(chosen)}")
                await keys.send_str(json.dumps(["stdin", "d"]))
                await seen(keys, "time_reversal")
                served.send_signal(signal.SIGINT)
                await ended(keys)

    try:
        asyncio.run(visit())
        out, err = served.communicate(timeout=60)
    finally:
        served.kill()
    assert rest == f"to browse {filled_once}; Ctrl-C stops it\n"
    assert (served.returncode, out, err) == (0, "", "")


def test_nobody_without_the_token_sees_a_page(filled_once):
    """This tests the server without a session, which takes under a second."""
    aiohttp = pytest.importorskip("aiohttp")
    from aiohttp.test_utils import TestClient, TestServer

    from orbitdb.cli.tui.web import TokenServer

    async def visit():
        server = TokenServer(["browse"], 0)
        async with TestClient(TestServer(await server.guarded())) as client:
            for path in ("/", "/ws", "/static/js/textual.js", f"/{'0' * 32}/", f"/{server.token[:-1]}/"):
                assert (await client.get(path, allow_redirects=False)).status == 403
            with pytest.raises(aiohttp.WSServerHandshakeError, match="403"):
                await client.ws_connect("/ws")
            assert (await client.get(f"/{server.token}/", allow_redirects=False)).status != 403

    asyncio.run(visit())


BAD = [
    "[1]", "{}", "[]", "null", "no json", '["resize", {}]', '{"a": 1}', '["stdin", 5]', '["stdin"]',
    '["resize", {"width": 100000, "height": 100000}]', '["resize", {"width": -5, "height": 24}]',
    '["resize", {"width": "80", "height": 24}]', '["resize", {"width": true, "height": 24}]',
    json.dumps(["stdin", "x" * 500_000]), "[" * 200_000, '["nothing that is known", 1]',
]  # fmt: skip


def test_messages_no_page_would_send_are_dropped():
    pytest.importorskip("aiohttp")
    from orbitdb.cli.tui.web import Session

    handed = []

    class Heard(Session):
        async def send_bytes(self, data):
            handed.append(data)

        async def send_meta(self, data):
            handed.append(data)

    async def send():
        nobody: Any = None
        session = Heard("", write_bytes=nobody, write_str=nobody, close=nobody, download_manager=nobody)
        for text in [*BAD, '["stdin", "\\ud800x"]', '["resize", {"width": 90, "height": 30}]', '["blur"]']:
            await session.take(text, nobody)

    asyncio.run(send())
    assert handed == [b"?x", {"type": "resize", "width": 90, "height": 30}, {"type": "blur"}]


@pytest.mark.slow
def test_a_session_survives_bad_messages_and_ends_with_the_server(filled_once):
    """Unread keys fill the pipe to the program, which is ended anyway."""
    aiohttp = pytest.importorskip("aiohttp")
    served = start("browse", "--web", "--port", "0", "--db", filled_once)
    page = there(served.stderr).readline().removeprefix("open ").partition(" ")[0]

    async def visit():
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{page}ws?width=99999&height=-1") as keys,
        ):
            await seen(keys, "lambda")
            for text in BAD:
                await keys.send_str(text)
            await keys.send_str(json.dumps(["stdin", "?"]))
            await seen(keys, "keys")
            for _ in range(200):
                await keys.send_str(json.dumps(["stdin", "j" * 5000]))
            served.send_signal(signal.SIGINT)
            await ended(keys)

    try:
        asyncio.run(visit())
        out, err = served.communicate(timeout=60)
        assert nobody_left(served)
    finally:
        served.kill()
    assert (served.returncode, out) == (0, "")
    assert "Traceback" not in err


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="a process keeps its parent's number there")
def test_a_session_ends_after_the_server_was_killed(filled_once):
    aiohttp = pytest.importorskip("aiohttp")
    served = start("browse", "--web", "--port", "0", "--db", filled_once)
    page = there(served.stderr).readline().removeprefix("open ").partition(" ")[0]

    async def visit():
        async with aiohttp.ClientSession() as session, session.ws_connect(f"{page}ws") as keys:
            await seen(keys, "lambda")
            with suppress(TimeoutError):  # a session that still draws would notice at once
                while True:
                    await keys.receive(timeout=1.0)
            served.kill()

    try:
        asyncio.run(visit())
        assert nobody_left(served)
    finally:
        with suppress(ProcessLookupError):
            kill_group(served)
        served.communicate()


@pytest.mark.slow
def test_an_error_while_serving_is_reported_in_one_line(cli, filled_once, monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        refused = cli("browse", "--web", "--port", str(port), "--db", str(filled_once))
    assert refused.says(2, f"port {port} cannot be used (Address already in use): choose another")
    assert cli("browse", "--web", "--where", "lenght < 3", "--db", str(filled_once)).says(2, "lenght")
    monkeypatch.setitem(sys.modules, "textual_serve.server", None)
    monkeypatch.delitem(sys.modules, "orbitdb.cli.tui.web", raising=False)
    assert cli("browse", "--web", "--db", str(filled_once)).says(1, "pip install 'orbitdb[web]'")
