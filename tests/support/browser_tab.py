"""A real Chromium for the tests of pages, which are skipped where there is none."""

import os
import re
import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

playwright = pytest.importorskip("playwright.sync_api", reason="`make setup` installs it")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
NEEDS_CHROMIUM = [
    pytest.mark.skipif(CHROMIUM is None, reason="no Chromium here: apt-get install chromium"),
    pytest.mark.xdist_group("browser"),
]
WORM = [sys.executable, "-c", "from worm_bringup.cli.app import main; main()"]
WAIT_MS = 180_000
WINDOWS = [(1280, 800), (390, 844)]


@contextmanager
def running_chromium():
    """Give a browser, and close it."""
    with playwright.sync_playwright() as driver:
        sandbox = ["--no-sandbox"] if os.geteuid() == 0 else []
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=sandbox)
        yield browser
        browser.close()


@contextmanager
def page_of(words, said_on, *, ends_by_itself):
    """Run `worm`, give the address of the page that it prints, and see it end in good order."""
    streams = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, said_on: subprocess.PIPE}
    process = subprocess.Popen([*WORM, *map(str, words)], text=True, **streams)
    try:
        found = re.search(r"http://127\.0\.0\.1:\d+/", getattr(process, said_on).readline())
        assert found, process.communicate()[1]
        yield found.group()
        if not ends_by_itself:
            process.terminate()
        said = process.communicate(timeout=300)[1]
        assert process.returncode == 0, said
    finally:
        process.kill()
        process.communicate()


class Tab:
    """A page that notes what it asks for and what goes wrong in it."""

    def __init__(self, browser, address, size=WINDOWS[0], scheme="light"):
        width, height = size
        self.page = browser.new_page(
            viewport={"width": width, "height": height}, color_scheme=scheme
        )
        self.page.set_default_timeout(WAIT_MS)
        self.wrong, self.asked = [], []
        self.page.on("console", lambda said: self.wrong.append(said.text))
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.on("websocket", lambda socket: self.asked.append(socket.url))
        self.page.goto(address)

    def text(self, name):
        """What an element shows."""
        return self.page.locator(f"#{name}").inner_text()

    def until(self, script, *argument):
        """Wait until a function of the page is true."""
        self.page.wait_for_function(script, arg=argument[0] if argument else None)
