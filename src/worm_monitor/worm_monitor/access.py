"""Who may look: the names that the page answers to, where a request may come from, the token."""

import hmac
import secrets
import socket
from collections.abc import Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

from worm_msgs_py.ros.network import is_ip_address, is_loopback

_TOKEN_BYTES = 16


@dataclass(frozen=True, slots=True)
class Access:
    """The rule for one page.

    Attributes
    ----------
    host : str
        Address that is listened on.
    port : int
    token : str
        First part of every path; empty where this machine alone can look.
    """

    host: str
    port: int
    token: str = ""

    @classmethod
    def to(cls, host: str, port: int, token: str = "") -> "Access":
        """Return the rule; a page that other machines reach has a token, given or new."""
        if not token and not is_loopback(host):
            token = secrets.token_urlsafe(_TOKEN_BYTES)
        return cls(host, port, token)

    @property
    def address(self) -> str:
        """What a person types."""
        host = socket.gethostname() if self.host in ("0.0.0.0", "::") else self.host
        host = f"[{host}]" if ":" in host else host
        return f"http://{host}:{self.port}/" + (f"{self.token}/" if self.token else "")

    def refusal(self, headers: Mapping[str, str], *, acts: bool) -> str:
        """Return why a request is refused; empty where it is not.

        A page of somebody else's that is open in the same browser may ask for ours under a name
        of its own (then Host is foreign) or open our socket (then Origin is).

        Parameters
        ----------
        headers : mapping
            Of the request.
        acts : bool
            Whether it asks for more than to read, such as a WebSocket, or a change: then it must
            say where it comes from.
        """
        host = headers.get("Host", "")
        if not self._is_ours(host):
            return "this page does not answer to that host"
        origin = headers.get("Origin")
        if (acts or origin is not None) and origin != f"http://{host}":
            return "this page answers to itself alone"
        return ""

    def opens(self, token: str) -> bool:
        """Tell whether this is the token, in a time that says nothing of it."""
        return hmac.compare_digest(token.encode(), self.token.encode())

    def _is_ours(self, host: str) -> bool:
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname or "", parts.port or 80
        except ValueError:
            return False
        if port != self.port:
            return False
        if is_loopback(self.host):
            return name == "localhost" or is_loopback(name)
        # By number or by this machine's own name: no page elsewhere can take either for its own.
        return is_ip_address(name) or name in (self.host, socket.gethostname().lower(), "localhost")
