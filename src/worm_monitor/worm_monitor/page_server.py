"""Serves the page and a socket for each browser, in a thread of its own; nobody is waited for."""

import asyncio
import contextlib
import json
import queue
import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aiohttp import WSMsgType, web

from worm_monitor.access import Access
from worm_monitor.site import Site, page_files
from worm_msgs_py.errors import BadInput, BadPicture

MOST_BROWSERS = 16
MOST_UNSENT = 100
"""Messages that a browser may be behind, ten seconds' worth; one that is more is dropped."""
_MOST_COMMANDS = 64
_HEARTBEAT_S = 15.0
_GOODBYE_S = 1.0
_PAGE = Path(__file__).with_name("page")


class Browser:
    """One socket: what it is still to be sent, and whether it has shown its last picture."""

    def __init__(self, socket: web.WebSocketResponse) -> None:
        self.wants_picture = True
        self.is_new = True
        self._socket = socket
        self._texts: deque[str] = deque()
        self._picture: bytes | None = None
        self._more = asyncio.Event()

    def tell(self, text: str) -> bool:
        """Send a text in its turn; return whether the browser keeps up."""
        self._texts.append(text)
        self._more.set()
        return len(self._texts) <= MOST_UNSENT

    def show(self, picture: bytes) -> None:
        """Send a picture; none follows until it is acknowledged."""
        self.wants_picture = False
        self._picture = picture
        self._more.set()

    async def say_goodbye(self) -> None:
        """Close the socket once it has been sent what there was."""
        while self._texts:
            await asyncio.sleep(0)
        await self._socket.close()

    async def send(self) -> None:
        """Send what there is, until the socket is closed."""
        while not self._socket.closed:
            await self._more.wait()
            self._more.clear()
            while self._texts:
                await self._socket.send_str(self._texts.popleft())
            if self._picture is not None:
                picture, self._picture = self._picture, None
                await self._socket.send_bytes(picture)


class PageServer:
    """The page's server. All of its methods may be called from any thread.

    Parameters
    ----------
    host : str
        Address to listen on.
    port : int
        0: `FIRST_PORT_TRIED`, or a free one where that is taken.
    token : str
        First part of every path; where other machines reach the page, a new one if empty.
    past : callable, optional
        Gives the frame that is next to a time in seconds, as pages take it; it is called in a
        thread of its own, and raises BadInput or BadPicture where it has none.

    Raises
    ------
    BadInput
        The address cannot be listened on.

    Attributes
    ----------
    commands : queue.Queue
        What browsers ask for, mappings; more than can be done are forgotten.
    """

    def __init__(
        self, host: str, port: int, token: str = "", past: Callable[[float], bytes] | None = None
    ) -> None:
        self._past = past
        self.commands: queue.Queue[dict[str, Any]] = queue.Queue(_MOST_COMMANDS)
        self._browsers: dict[Browser, asyncio.Task[None]] = {}
        self._last_picture: bytes | None = None
        self._one_past = asyncio.Lock()
        self._loop = asyncio.new_event_loop()
        routes = [web.get("/socket", self._socket), web.get("/past", self._past_frame)]
        self._site = Site(Access.to(host, port, token), page_files(_PAGE), routes)
        self._thread = threading.Thread(target=self._run, name="page", daemon=True)
        self._thread.start()
        try:
            asyncio.run_coroutine_threadsafe(self._site.listen(), self._loop).result()
        except OSError as error:
            self.close()
            raise BadInput(
                f"the monitor cannot listen on {host} port {port}: {error.strerror}; "
                "give another --monitor-port"
            ) from None

    @property
    def address(self) -> str:
        """What a person types into a browser."""
        return self._site.access.address

    @property
    def browsers(self) -> int:
        """How many browsers look."""
        return len(self._browsers)

    @property
    def has_new(self) -> bool:
        """Whether a browser waits for all that there is."""
        return any(browser.is_new for browser in tuple(self._browsers))

    @property
    def wants_picture(self) -> bool:
        """Whether a browser has shown its last picture."""
        return any(browser.wants_picture for browser in tuple(self._browsers))

    def tell(self, news: str, everything: str | None) -> None:
        """Send what is new to all, and all to those that have just come."""
        self._loop.call_soon_threadsafe(self._tell, news, everything)

    def show(self, picture: bytes) -> None:
        """Send a picture to those that wait for one."""
        self._loop.call_soon_threadsafe(self._show, picture)

    def close(self) -> None:
        """Close all sockets and end the thread."""
        if self._loop.is_closed():
            return
        with contextlib.suppress(TimeoutError, OSError):
            asyncio.run_coroutine_threadsafe(self._close(), self._loop).result(2 * _GOODBYE_S)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()

    async def _close(self) -> None:
        async with asyncio.timeout(_GOODBYE_S):
            for browser in tuple(self._browsers):
                await browser.say_goodbye()
        await self._site.close()

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if len(self._browsers) >= MOST_BROWSERS:
            return web.Response(status=503, text="too many browsers look already")
        socket = web.WebSocketResponse(heartbeat=_HEARTBEAT_S, max_msg_size=4096, compress=False)
        await socket.prepare(request)
        browser = Browser(socket)
        sender = asyncio.create_task(browser.send())
        self._browsers[browser] = sender
        if request.transport is not None:
            abort = request.transport.abort
            sender.add_done_callback(lambda _: abort())
        if self._last_picture is not None:
            browser.show(self._last_picture)
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    self._hear(browser, message.data)
        finally:
            sender.cancel()
            del self._browsers[browser]
        return socket

    async def _past_frame(self, request: web.Request) -> web.StreamResponse:
        """Answer with the frame next to `t`, seconds after the first one."""
        try:
            time_s = float(request.query.get("t", ""))
            if self._past is None:
                return web.Response(status=404, text="only a recording shows past frames")
            # one at a time: whoever asks quickly waits for himself
            async with self._one_past:
                frame = await asyncio.to_thread(self._past, time_s)
        except (ValueError, BadInput, BadPicture) as error:
            return web.Response(status=404, text=str(error))
        return web.Response(body=frame, content_type="application/octet-stream")

    def _hear(self, browser: Browser, text: str) -> None:
        try:
            said = json.loads(text)
        except ValueError:
            return
        if not isinstance(said, dict):
            return
        if "shown" in said:
            browser.wants_picture = True
        elif "do" in said:
            with contextlib.suppress(queue.Full):
                self.commands.put_nowait(said)

    def _tell(self, news: str, everything: str | None) -> None:
        for browser, sender in tuple(self._browsers.items()):
            if browser.is_new and everything is None:
                continue
            keeps_up = browser.tell(everything if browser.is_new and everything else news)
            browser.is_new = False
            if not keeps_up:
                sender.cancel()  # the transport is aborted then, and the browser comes again

    def _show(self, picture: bytes) -> None:
        self._last_picture = picture
        for browser in self._browsers:
            if browser.wants_picture:
                browser.show(picture)
