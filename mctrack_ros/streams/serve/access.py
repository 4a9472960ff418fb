"""Access to streams: for this machine, or whoever knows the token."""

from __future__ import annotations

import hmac
import ipaddress
import re
from dataclasses import dataclass
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

TOKEN = re.compile('[A-Za-z0-9_-]{8,}')


def check_address(host: str, token: str, how: str = 'a --token') -> None:
    """
    Refuse an address that other machines reach, unless a token guards it.

    Parameters
    ----------
    host, token : str
        The address, and the token; empty for none.
    how : str
        What a token is given by, to name.

    Raises
    ------
    ValueError
        If there is no token, or one that is too short or has signs that no address holds.

    """
    if token and not TOKEN.fullmatch(token):
        raise ValueError('the token: expected at least 8 letters, digits, - or _')
    if not token and not is_loopback(host):
        raise ValueError(
            f'other machines reach the page at {host!r}: give {how} of at least '
            '8 characters, or keep to 127.0.0.1'
        )


def is_loopback(host: str) -> bool:
    """Tell whether only this machine reaches an address."""
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


@dataclass(frozen=True, slots=True)
class Access:
    """
    What a request must bring.

    Attributes
    ----------
    host : str
        The address that is served.
    token : str
        The token; empty for none.
    origins : tuple of str
        Other sites whose pages may read, for example ``https://example.org``.

    """

    host: str
    token: str
    origins: tuple[str, ...] = ()

    def refusal(self, request: HTTPConnection, given: str) -> str:
        """Return why a request with a token is refused; empty if it is not."""
        if self.token:
            if not hmac.compare_digest(given.encode(), self.token.encode()):
                return 'The token is missing or wrong.'
        elif is_loopback(self.host) and not is_loopback(_host_name(request.headers)):
            return 'This page is for this machine alone.'
        origin = request.headers.get('origin')
        is_own = not origin or urlsplit(origin).netloc == request.headers.get('host', '')
        return '' if is_own or origin in self.origins else 'Another site may not use this page.'


class BearerGuard:
    """
    Refuse requests whose header ``Authorization: Bearer`` lacks the token (ASGI).

    Parameters
    ----------
    app : ASGIApp
        What is guarded.
    access : Access
        What a request must bring.

    """

    def __init__(self, app: ASGIApp, access: Access) -> None:
        self._app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        refused = ''
        if scope['type'] in ('http', 'websocket'):
            request = HTTPConnection(scope)
            kind, _, given = request.headers.get('authorization', '').partition(' ')
            refused = self._access.refusal(request, given if kind.lower() == 'bearer' else '')
        if not refused:
            await self._app(scope, receive, send)
        elif scope['type'] == 'websocket':
            await WebSocketClose(1008, refused)(scope, receive, send)
        else:
            headers = {'connection': 'close'}
            if self._access.token:
                headers['www-authenticate'] = 'Bearer'
            status = 401 if self._access.token else 403
            await PlainTextResponse(refused, status, headers)(scope, receive, send)


def _host_name(headers: Headers) -> str:
    return urlsplit('//' + headers.get('host', '')).hostname or ''
