import asyncio

import pytest
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute

from mctrack_ros.web import check_address
from mctrack_ros.web.serve.guard import COOKIE, Guard

TOKEN = 'a-long-token'


async def answer(socket):
    await socket.accept()
    await socket.close()


ROUTES = [Route('/', lambda request: PlainTextResponse('page')), WebSocketRoute('/', answer)]


def ask(host='127.0.0.1', token='', kind='http', query='', name='127.0.0.1:8080', **headers):
    """Return the first message with which a guarded page answers one request."""
    headers = {'host': name, **headers}
    scope = {
        **{'type': kind, 'method': 'GET', 'path': '/', 'query_string': query.encode()},
        'headers': [(name.encode(), value.encode()) for name, value in headers.items()],
    }
    sent = []

    async def receive():
        return {'type': 'websocket.connect' if kind == 'websocket' else 'http.request'}

    async def send(message):
        sent.append(message)

    asyncio.run(Guard(Starlette(routes=ROUTES), host, token)(scope, receive, send))
    return sent[0]


def is_let_in(**request):
    """Tell whether a page and a web socket are both let in; one alone fails."""
    page, socket = ask(**request), ask(kind='websocket', **request)
    assert page['status'] in (200, 403)
    assert (page['status'] == 200) == (socket['type'] == 'websocket.accept')
    return page['status'] == 200


@pytest.mark.parametrize('host', ['127.0.0.1', '127.0.0.9', '::1', 'localhost'])
def test_this_machine_alone_needs_no_token(host):
    check_address(host, '')


@pytest.mark.parametrize('host', ['0.0.0.0', '::', '192.0.2.7', 'example.org', ''])
def test_an_address_that_others_reach_needs_a_token(host):
    with pytest.raises(ValueError, match='--token'):
        check_address(host, '')
    check_address(host, TOKEN)


@pytest.mark.parametrize('token', ['short', 'with a blank', 'half;colon'])
def test_a_weak_token_is_refused(token):
    with pytest.raises(ValueError, match='at least 8'):
        check_address('127.0.0.1', token)


@pytest.mark.parametrize('host', ['0.0.0.0', '127.0.0.1'])
def test_with_a_token_every_request_brings_it(host):
    for query in ('', 'token=', 'token=wrong-token'):
        assert not is_let_in(host=host, token=TOKEN, query=query)
    assert not is_let_in(host=host, token=TOKEN, cookie=f'{COOKIE}=wrong-token')
    assert is_let_in(host=host, token=TOKEN, query=f'token={TOKEN}')
    assert is_let_in(host=host, token=TOKEN, cookie=f'{COOKIE}={TOKEN}')


def test_the_token_of_the_address_is_kept_in_a_cookie():
    headers = dict(ask(host='0.0.0.0', token=TOKEN, query=f'token={TOKEN}')['headers'])
    assert headers[b'set-cookie'].decode().startswith(f'{COOKIE}={TOKEN}; HttpOnly')


def test_no_other_site_uses_the_page():
    assert is_let_in()
    assert is_let_in(origin='http://127.0.0.1:8080')
    assert not is_let_in(origin='http://example.org')
    assert not is_let_in(
        host='0.0.0.0', token=TOKEN, query=f'token={TOKEN}', origin='http://example.org'
    )


def test_a_foreign_name_for_this_machine_is_refused():
    assert is_let_in(name='localhost:8080')
    assert not is_let_in(name='example.org:8080')
