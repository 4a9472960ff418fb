"""Access to a page: for this machine, or whoever knows the token."""

from __future__ import annotations

import hmac
from urllib.parse import parse_qs

from starlette.requests import HTTPConnection, Request
from starlette.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from mctrack_ros.streams.serve.access import Access

COOKIE = 'mctrack_session'
LARGEST_BODY = 1 << 20
"""Of a request, bytes."""
_LARGEST_FORM = 1024
_FORM = (
    '<!doctype html><meta name="viewport" content="width=device-width"><title>Token</title>'
    '<form method="post" action="/"><label>{} Token: <input type="password" name="token" '
    'autocomplete="current-password" autofocus></label> <button>Enter</button></form>'
)
_SILENT = {'referrer-policy': 'same-origin', 'cache-control': 'no-store'}


class Guard:
    """
    Refuse requests without the token, and such as another site's page sends (ASGI).

    Web sockets are guarded as pages are. Who comes without is asked for the token. The query
    parameter ``token`` is taken too. Either is answered by a cookie, derived from the token, and
    the page's own address, so that the token stays neither there nor in the browser's history.

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
        self._session = hmac.digest(token.encode(), b'session of mctrack', 'sha256').hex()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope['type'] not in ('http', 'websocket'):
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        held = request.cookies.get(COOKIE, '')
        known = hmac.compare_digest(held.encode(), self._session.encode())
        refused = self._access.refusal(request, self._access.token if known else '')
        if scope['type'] == 'websocket':
            if refused:
                await WebSocketClose(1008, refused)(scope, receive, send)
            else:
                await self._app(scope, receive, send)
            return
        answer: Response | None = None
        if _is_too_large(request):
            answer = PlainTextResponse('The request is too large.', 413)
        elif refused:
            answer = await self._sign_in(Request(scope, receive), refused)
        elif self._access.token and 'token' in request.query_params:
            answer = RedirectResponse('/', 303, _SILENT)
        await (answer or self._app)(scope, receive, send)

    async def _sign_in(self, request: Request, refused: str) -> Response:
        """Take the token of a form or a query, or ask for it."""
        given = request.query_params.get('token', '')
        if (
            request.method == 'POST'
            and request.url.path == '/'
            and _size(request) <= _LARGEST_FORM
        ):
            given = parse_qs((await request.body()).decode(errors='replace')).get('token', [''])[0]
        refused = self._access.refusal(request, given) if given else refused
        if refused:
            may_ask = self._access.token and 'text/html' in request.headers.get('accept', '')
            kind = HTMLResponse if may_ask else PlainTextResponse
            return kind(_FORM.format(refused) if may_ask else refused, 403, _SILENT)
        answer = RedirectResponse('/', 303, _SILENT)
        answer.set_cookie(COOKIE, self._session, httponly=True)
        return answer


def _size(request: HTTPConnection) -> int:
    stated = request.headers.get('content-length', '0')
    return int(stated) if stated.isdigit() else LARGEST_BODY + 1


def _is_too_large(request: HTTPConnection) -> bool:
    """Tell whether a body is larger than any is here, or does not say how large it is."""
    return 'transfer-encoding' in request.headers or _size(request) > LARGEST_BODY
