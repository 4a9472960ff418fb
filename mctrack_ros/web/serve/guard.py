"""Who may see a page: this machine, or whoever knows the token."""

from __future__ import annotations

from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from mctrack_ros.streams.serve.access import Access

COOKIE = 'mctrack_token'


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
        self._app, self._access = app, Access(host, token)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope['type'] not in ('http', 'websocket'):
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        given = request.query_params.get('token') or request.cookies.get(COOKIE, '')
        refused = self._access.refusal(request, given)
        if not refused:
            await self._app(scope, receive, self._with_cookie(request, send))
        elif scope['type'] == 'websocket':
            await WebSocketClose(1008, refused)(scope, receive, send)
        else:
            await PlainTextResponse(refused, 403)(scope, receive, send)

    def _with_cookie(self, request: HTTPConnection, send: Send) -> Send:
        """Keep the token of a page's query for what the page asks for next."""
        if request.scope['type'] != 'http' or 'token' not in request.query_params:
            return send

        async def sending(message: Message) -> None:
            if message['type'] == 'http.response.start' and self._access.token:
                cookie = f'{COOKIE}={self._access.token}; HttpOnly; SameSite=Strict; Path=/'
                MutableHeaders(scope=message).append('set-cookie', cookie)
            await send(message)

        return sending
