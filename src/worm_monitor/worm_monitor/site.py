"""A site that answers to its own pages alone: who may ask, and what a page of it may load."""

from collections.abc import Awaitable, Callable, Iterable, Mapping
from pathlib import Path

from aiohttp import web

from worm_monitor.access import Access

FIRST_PORT_TRIED = 8642
_MEDIA_TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
_READING = ("GET", "HEAD")
_MOST_ASKED_BYTES = 64 << 10
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def page_files(*folders: Path) -> dict[str, bytes]:
    """Return the files of a page by their names; of one name that of the last folder."""
    return {
        item.name: item.read_bytes()
        for folder in folders
        for item in folder.iterdir()
        if item.suffix in _MEDIA_TYPES
    }


def _headers(host: str) -> dict[str, str]:
    """Return what a browser is told: nothing from elsewhere, no script that is not a file here."""
    policy = (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
        f"connect-src 'self' ws://{host}; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    )
    return {
        "Content-Security-Policy": policy,
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cross-Origin-Opener-Policy": "same-origin",
        "Cache-Control": "no-store",
    }


class Site:
    """The files of a page and what it asks for, behind one guard.

    Parameters
    ----------
    access : Access
        Who may look; where its port is 0, `FIRST_PORT_TRIED` or a free one.
    files : mapping of name to content
        `index.html` is the page.
    routes : iterable of aiohttp.web.RouteDef
        What else is answered, by paths below the token.
    """

    def __init__(
        self, access: Access, files: Mapping[str, bytes], routes: Iterable[web.RouteDef]
    ) -> None:
        self.access = access
        self._files = files

        async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
            return await self._guard(request, handler)

        application = web.Application(
            middlewares=[web.middleware(guard)], client_max_size=_MOST_ASKED_BYTES
        )
        prefix = "/{token}" if access.token else ""
        application.router.add_get(f"{prefix}/", self._file)
        for route in routes:
            application.router.add_route(route.method, prefix + route.path, route.handler)
        application.router.add_get(f"{prefix}/{{name}}", self._file)
        self._runner = web.AppRunner(application, access_log=None)

    async def listen(self) -> None:
        """Begin to answer; OSError where the address cannot be listened on."""
        await self._runner.setup()
        access = self.access
        for port in (access.port,) if access.port else (FIRST_PORT_TRIED, 0):
            try:
                await web.TCPSite(self._runner, access.host, port).start()
                break
            except OSError:
                if port in (access.port, 0):
                    raise
        port = int(self._runner.addresses[0][1])
        self.access = Access(access.host, port, access.token)

    async def close(self) -> None:
        """Answer no more."""
        await self._runner.cleanup()

    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse what does not come from the page itself; say in each answer what a page may do."""
        is_socket = request.headers.get("Upgrade", "").lower() == "websocket"
        acts = is_socket or request.method not in _READING
        why = self.access.refusal(request.headers, acts=acts)
        if why:
            return web.Response(status=403, text=why)
        if self.access.token and not self.access.opens(request.match_info.get("token", "")):
            return web.Response(status=404, text="nothing here")
        response = await handler(request)
        if not response.prepared:
            response.headers.update(_headers(request.host))
        return response

    async def _file(self, request: web.Request) -> web.StreamResponse:
        name = request.match_info.get("name", "index.html")
        if name not in self._files:
            return web.Response(status=404, text="nothing here")
        kind = _MEDIA_TYPES[Path(name).suffix]
        return web.Response(body=self._files[name], content_type=kind, charset="utf-8")
