"""The screen in a browser: textual-serve runs the program once for each open page.

A user of the screen can fill the catalogue and write files. The server is therefore reachable only from this
machine, and every address begins with a secret token, so other pages in the same browser cannot reach it.
"""

import asyncio
import json
import logging
import os
import secrets
import shlex
import signal
import socket
import subprocess
import sys
from collections.abc import Awaitable, Callable, Sequence
from contextlib import redirect_stdout, suppress
from io import StringIO
from typing import cast

from aiohttp import WSMsgType, web
from textual_serve.app_service import AppService
from textual_serve.server import Server

from orbitdb.cli.interrupts import TERMINATING, Terminated
from orbitdb.errors import InputError

HOST = "127.0.0.1"
_LOG = logging.getLogger("textual-serve")
_SECONDS = 5.0
"""Seconds that a session has to end by itself before it is killed."""
_HEARTBEAT = 15.0
_USUAL, _LARGEST = (80, 24), (1000, 500)
"""Default and largest numbers of columns and rows of a terminal."""
_LONGEST = 1 << 16
"""Maximum number of characters in one message of keys, such as pasted text."""
_REFUSAL = "this address lacks the token: open the address that 'orbitdb browse --web' printed\n"
_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; script-src 'self' 'unsafe-inline'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data:; connect-src 'self' {here}; "
    "frame-ancestors 'none'",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}

_MORE = """\
<link rel="icon" href="data:,">
<script>
new MutationObserver((changes, observer) => {
  const keys = document.querySelector(".xterm-helper-textarea");
  if (keys && document.body.classList.contains("-first-byte")) {
    observer.disconnect();
    keys.focus();
  }
}).observe(document.body, {attributes: true, attributeFilter: ["class"]});
</script>
"""
"""Puts the keyboard focus on the screen as soon as it appears, so that keys work without a click."""

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def serve(arguments: Sequence[str], port: int, tell: Callable[[str], None]) -> None:
    """Serve ``orbitdb browse`` with the given arguments until Ctrl-C or another signal.

    Port 0 means any free port. `tell` gets the address once the server answers. Any signal but Ctrl-C raises
    `Terminated`.
    """
    try:
        listening = socket.create_server((HOST, port))
    except OSError as error:
        reason = os.strerror(error.errno or 0)
        raise InputError(
            f"port {port} cannot be used ({reason}): choose another, or 0 for any free port, with --port"
        ) from None
    server = TokenServer(arguments, listening.getsockname()[1])
    with listening, redirect_stdout(StringIO()):
        web.run_app(
            server.guarded(),
            sock=listening,
            access_log=None,
            handle_signals=False,
            shutdown_timeout=_SECONDS,
            print=lambda _: tell(server.address),
        )
    if server.told != signal.SIGINT:
        raise Terminated(server.told)


class TokenServer(Server):
    """A server whose addresses begin with a secret token; `told` is the signal that ended it."""

    def __init__(self, arguments: Sequence[str], port: int) -> None:
        program = [sys.executable, "-P", "-c", "from orbitdb.cli.main import run; run()", *arguments]
        windows = sys.platform == "win32"
        command = subprocess.list2cmdline(program) if windows else f"exec {shlex.join(program)}"
        super().__init__(command, HOST, port, "orbitdb browse", f"http://{HOST}:{port}")
        self.token = secrets.token_hex(16)
        self.told: int = signal.SIGINT
        self._sessions: set[asyncio.Task[object]] = set()

    @property
    def address(self) -> str:
        """The address of the page, including the token."""
        return f"{self.public_url}/{self.token}/"

    async def guarded(self) -> web.Application:
        """Return a web application that serves textual-serve under the token, and nothing else."""

        @web.middleware
        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            given = request.path.partition("/")[2].partition("/")[0]
            if not secrets.compare_digest(given.encode(errors="replace"), self.token.encode()):
                return web.Response(status=403, text=_REFUSAL)
            if request.headers.get("Origin", self.public_url) != self.public_url:  # from another site
                return web.Response(status=403, text="only pages of this server can open a session\n")
            meant = request.host == f"{HOST}:{self.port}"  # under another host name, the origin would differ
            if request.method == "GET" and not (meant and request.path != f"/{self.token}"):
                raise web.HTTPFound(self.address)
            return await handler(request)

        async def add_headers(request: web.Request, response: web.StreamResponse) -> None:
            here = f"ws://{HOST}:{self.port}"
            response.headers.update({name: text.format(here=here) for name, text in _HEADERS.items()})

        app = web.Application(middlewares=[guard])
        app.add_subapp(f"/{self.token}/", await self._make_app())
        app.on_response_prepare.append(add_headers)
        return app

    async def on_startup(self, app: web.Application) -> None:
        """Handle signals. No address is printed here, because the command announces it."""

        def end(number: int) -> None:
            self.told = number
            raise web.GracefulExit

        with suppress(NotImplementedError):  # on Windows, Ctrl-C ends the loop by itself
            for number in (signal.SIGINT, *TERMINATING):
                asyncio.get_running_loop().add_signal_handler(number, end, number)

    async def on_shutdown(self, app: web.Application) -> None:
        """End all sessions and their processes, without logging the work that this interrupts."""
        for log in (_LOG, logging.getLogger("asyncio")):
            log.disabled = True
        for session in self._sessions:
            session.cancel()
        if self._sessions:
            await asyncio.wait(self._sessions, timeout=2 * _SECONDS)

    async def handle_index(self, request: web.Request) -> web.Response:
        """Return the page of textual-serve, with `_MORE` inserted."""
        page = cast(web.Response, await super().handle_index(request))
        page.text = (page.text or "").replace("</body>", f"{_MORE}</body>")
        return page

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """Run a session on a websocket; refuse other requests, which aiohttp would report as our errors."""
        if not web.WebSocketResponse().can_prepare(request):
            raise web.HTTPBadRequest(text="a session needs a websocket\n")
        task = asyncio.current_task()
        assert task is not None
        self._sessions.add(task)
        socket = web.WebSocketResponse(heartbeat=_HEARTBEAT)

        async def close() -> None:
            await socket.close()

        session = Session(
            self.command,
            write_bytes=socket.send_bytes,
            write_str=socket.send_str,
            close=close,
            download_manager=self.download_manager,
        )
        try:
            await socket.prepare(request)
            await session.start(*_size(request.query.get("width"), request.query.get("height")))
            async for message in socket:
                await session.take(message.data if message.type == WSMsgType.TEXT else "", socket)
        except (asyncio.CancelledError, ConnectionError):
            pass
        finally:
            await session.stop()
            await socket.close()
            self._sessions.discard(task)
        return socket


class Session(AppService):
    """The process that runs the program for one open page, and the messages from that page."""

    async def take(self, text: str, socket: web.WebSocketResponse) -> None:
        """Pass a message from the page on to the program; drop invalid messages."""
        with suppress(ValueError, RecursionError):  # not JSON, or too many brackets
            match json.loads(text):
                case ["stdin", str(keys)] if len(keys) <= _LONGEST:
                    await self.send_bytes(keys.encode(errors="replace"))
                case ["resize", {"width": width, "height": height}] if _is_size(width, height):
                    await self.set_terminal_size(width, height)
                case ["ping", data]:
                    await socket.send_json(["pong", data])
                case ["blur", *_]:
                    await self.blur()
                case ["focus", *_]:
                    await self.focus()

    async def stop(self) -> None:
        """Ask the program to end, and kill it if it is still running after `_SECONDS`."""
        try:
            async with asyncio.timeout(_SECONDS):
                await super().stop()
        except (TimeoutError, asyncio.CancelledError):
            pass
        finally:
            if self._process is not None and self._process.returncode is None:
                with suppress(ProcessLookupError):
                    self._process.kill()
                await self._process.wait()


def _is_size(width: object, height: object) -> bool:
    """Tell whether a terminal can have this width and height."""
    return all(
        type(each) is int and 1 <= each <= most for each, most in zip((width, height), _LARGEST, strict=True)
    )


def _size(width: str | None, height: str | None) -> tuple[int, int]:
    """Return the width and height given in an address, or the default if they are missing or invalid."""
    with suppress(ValueError):
        asked = int(width or ""), int(height or "")
        if _is_size(*asked):
            return asked
    return _USUAL
