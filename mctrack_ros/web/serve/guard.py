"""Who may see a page: this machine, or whoever knows the token."""

from __future__ import annotations

import hmac
import ipaddress
import re
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

TOKEN = re.compile('[A-Za-z0-9_-]{8,}')
COOKIE = 'mctrack_token'


def check_address(host: str, token: str) -> None:
    """
    Refuse an address that other machines reach, unless a token guards it.

    Raises
    ------
    ValueError
        If there is no token, or one that is too short or has signs that no address holds.

    """
    if token and not TOKEN.fullmatch(token):
        raise ValueError('the token: expected at least 8 letters, digits, - or _')
    if not token and not is_loopback(host):
        raise ValueError(
            f'other machines reach the page at {host!r}: give a --token of at least '
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


class Guard:
    """
    Refuse requests without the token, and such as another site's page sends (ASGI).

    Web sockets are guarded as pages are. The token comes as the query parameter ``token`` and is
    then kept in a cookie.

    Parameters
    ----------
    app : ASGIApp
        What is guarded.
    host : str
        The address that it is bound to.
    token : str
        The token; empty for none.

    """

    def __init__(self, app: ASGIApp, host: str, token: str) -> None:
        self._app, self._local, self._token = app, is_loopback(host), token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope['type'] not in ('http', 'websocket'):
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        refused = self._refusal(request)
        if not refused:
            await self._app(scope, receive, self._with_cookie(request, send))
        elif scope['type'] == 'websocket':
            await WebSocketClose(1008, refused)(scope, receive, send)
        else:
            await PlainTextResponse(refused, 403)(scope, receive, send)

    def _refusal(self, request: HTTPConnection) -> str:
        """Return why a request is refused; empty if it is not."""
        if self._token:
            given = request.query_params.get('token') or request.cookies.get(COOKIE, '')
            if not hmac.compare_digest(given.encode(), self._token.encode()):
                return 'This page needs its token: open the address that was printed.'
        elif self._local and not is_loopback(_host_name(request.headers)):
            return 'This page is for this machine alone.'
        origin = request.headers.get('origin')
        if origin and urlsplit(origin).netloc != request.headers.get('host', ''):
            return 'Another site may not use this page.'
        return ''

    def _with_cookie(self, request: HTTPConnection, send: Send) -> Send:
        """Keep the token of a page's query for what the page asks for next."""
        if request.scope['type'] != 'http' or 'token' not in request.query_params:
            return send

        async def sending(message: Message) -> None:
            if message['type'] == 'http.response.start' and self._token:
                cookie = f'{COOKIE}={self._token}; HttpOnly; SameSite=Strict; Path=/'
                MutableHeaders(scope=message).append('set-cookie', cookie)
            await send(message)

        return sending


def _host_name(headers: Headers) -> str:
    return urlsplit('//' + headers.get('host', '')).hostname or ''
