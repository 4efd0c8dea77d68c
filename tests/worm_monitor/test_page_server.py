"""The server gives its page to whom it is meant for, and waits for no browser."""

import asyncio
import json
import re
import socket
import urllib.error
import urllib.request

import aiohttp
import pytest

from worm_monitor.page_server import MOST_BROWSERS, MOST_UNSENT, PageServer
from worm_msgs_py.colours import (
    CENTROID_COLOUR,
    EXIT_COLOUR,
    HEAD_COLOUR,
    MIDLINE_COLOUR,
    TAIL_COLOUR,
    WALL_COLOUR,
)
from worm_msgs_py.errors import BadInput

QUICK = aiohttp.ClientWSTimeout(ws_close=0.1)
"""A stalled browser does not answer when it is closed."""


@pytest.fixture
def server():
    made = PageServer("127.0.0.1", free_port())
    yield made
    made.close()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def get(address, **headers):
    """Return the status, headers and text of an answer."""
    request = urllib.request.Request(address, headers=headers)
    try:
        with urllib.request.urlopen(request) as answer:
            return answer.status, answer.headers, answer.read().decode()
    except urllib.error.HTTPError as error:
        return error.code, error.headers, error.read().decode()


def test_the_page_and_all_that_it_names_are_there_and_nothing_comes_from_elsewhere(server):
    status, headers, text = get(server.address)
    assert status == 200
    names = re.findall(r'(?:href|src)="([^"]+)"', text)
    assert len(names) >= 3
    for name in names:
        status, _, more = get(server.address + name)
        assert status == 200
        text += more
    for name in re.findall(r'from "\./([^"]+)"', text):
        status, _, more = get(server.address + name)
        assert status == 200
        text += more
    assert not [a for a in re.findall(r"https?://[^\"' )>]+", text) if "www.w3.org" not in a]
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'self';" in policy
    assert "unsafe" not in policy
    for colour in (HEAD_COLOUR, CENTROID_COLOUR, TAIL_COLOUR, WALL_COLOUR, EXIT_COLOUR):
        assert text.count(colour) >= 2  # of the picture and of the plots
    assert MIDLINE_COLOUR in text


def test_a_foreign_host_or_origin_gets_nothing(server):
    assert get(server.address, Host="evil.example")[0] == 403
    assert get(server.address, Origin="http://evil.example")[0] == 403
    assert get(server.address + "socket")[0] != 200
    assert get(server.address + "../setup.py")[0] == 404


def test_a_page_with_a_token_is_under_it_alone():
    server = PageServer("127.0.0.1", free_port(), "secret")
    try:
        root = server.address.removesuffix("secret/")
        assert get(server.address)[0] == 200
        assert get(server.address + "page.js")[0] == 200
        for path in ("", "secre/", "page.js", "wrong/page.js", "wrong/socket"):
            assert get(root + path)[0] == 404
    finally:
        server.close()


def test_a_port_that_is_taken_is_refused_and_the_default_gives_way(server):
    port = int(server.address.rstrip("/").rpartition(":")[2])
    with pytest.raises(BadInput, match=f"port {port}.*--monitor-port"):
        PageServer("127.0.0.1", port)
    first, second = PageServer("127.0.0.1", 0), PageServer("127.0.0.1", 0)
    try:
        assert first.address != second.address
        assert get(second.address)[0] == 200
    finally:
        first.close()
        second.close()


async def until(true):
    """Let other tasks run until something is true."""
    async with asyncio.timeout(20.0):
        while not true():
            await asyncio.sleep(0)


def with_sockets(server, count, talk):
    """Open sockets as the page does; run a coroutine with them."""

    async def run():
        async with aiohttp.ClientSession() as session:
            origin = server.address.rstrip("/")
            sockets = [
                await session.ws_connect(server.address + "socket", origin=origin, timeout=QUICK)
                for _ in range(count)
            ]
            await until(lambda: server.browsers == count)
            await talk(session, *sockets)
            for socket in sockets:
                await socket.close()

    return asyncio.run(run())


def test_a_socket_from_another_page_is_refused(server):
    async def talk(session):
        for origin in (None, "http://evil.example"):
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await session.ws_connect(server.address + "socket", origin=origin, timeout=QUICK)
            assert refused.value.status == 403

    with_sockets(server, 0, talk)


def test_whoever_comes_late_gets_everything_and_then_the_news(server):
    async def talk(session, early):
        server.tell("news 1", "everything 1")
        assert await early.receive_str() == "everything 1"
        late = await session.ws_connect(
            server.address + "socket", origin=server.address.rstrip("/")
        )
        await until(lambda: server.has_new)
        server.tell("news 2", None)  # the late one was not there yet when this was put together
        server.tell("news 3", "everything 3")
        assert await late.receive_str() == "everything 3"
        assert [await early.receive_str() for _ in range(2)] == ["news 2", "news 3"]

    with_sockets(server, 1, talk)


def test_the_next_picture_comes_only_after_the_last_one_was_shown(server):
    async def talk(session, browser):
        assert server.wants_picture
        server.show(b"first")
        assert await browser.receive_bytes() == b"first"
        await until(lambda: not server.wants_picture)
        server.show(b"second")
        await browser.send_str('{"shown": true}')
        await until(lambda: server.wants_picture)
        server.show(b"third")
        assert await browser.receive_bytes() == b"third"

    with_sockets(server, 1, talk)


def test_what_a_browser_asks_for_is_kept_in_order_and_nonsense_is_passed_over(server):
    async def talk(session, browser):
        for said in ("[", "7", '{"x": 1}', '{"do": "pause"}', '{"do": "rate", "value": 2}'):
            await browser.send_str(said)
        await until(lambda: server.commands.qsize() == 2)
        assert server.commands.get() == {"do": "pause"}
        for _ in range(200):
            await browser.send_str('{"do": "pause"}')
        await browser.send_str('{"shown": true}')
        server.show(b"picture")
        await browser.receive_bytes()
        assert server.commands.qsize() <= server.commands.maxsize

    with_sockets(server, 1, talk)


def test_a_browser_that_reads_nothing_is_dropped_and_another_one_is_not(server):
    """What is not read fills the socket's buffers first; then it waits, within bounds."""

    async def talk(session, stalled, other):
        large = json.dumps("x" * 200_000)
        stalled._response.connection.transport.pause_reading()
        for _ in range(MOST_UNSENT + 60):
            server.tell(large, large)
            assert await other.receive_str() == large
            if server.browsers == 1:
                break
        assert server.browsers == 1
        server.tell("last", None)
        assert await other.receive_str() == "last"

    with_sockets(server, 2, talk)


def test_there_are_only_so_many_browsers(server):
    async def talk(session, *browsers):
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            await session.ws_connect(server.address + "socket", origin=server.address.rstrip("/"))
        assert refused.value.status == 503

    with_sockets(server, MOST_BROWSERS, talk)


def test_past_frames_are_asked_for_by_their_time_and_a_refusal_says_why():
    def past(time_s):
        if time_s > 9.0:
            raise BadInput("no frame has been tracked yet")
        return f"frame of {time_s}".encode()

    server = PageServer("127.0.0.1", free_port(), past=past)
    try:
        assert get(server.address + "past?t=2.5")[::2] == (200, "frame of 2.5")
        assert get(server.address + "past?t=10")[::2] == (404, "no frame has been tracked yet")
        for nonsense in ("past", "past?t=", "past?t=x"):
            assert get(server.address + nonsense)[0] == 404
        assert get(server.address + "past?t=1", Origin="http://evil.example")[0] == 403
    finally:
        server.close()


def test_a_live_trial_shows_no_past_frames(server):
    status, _, why = get(server.address + "past?t=1")
    assert status == 404
    assert "recording" in why
