import asyncio

import pytest
from starlette.applications import Starlette
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute

from mctrack_ros.web import check_address
from mctrack_ros.web.serve.guard import COOKIE, LARGEST_BODY, Guard

TOKEN = 'a-long-token'


async def answer(socket):
    await socket.accept()
    await socket.close()


ROUTES = [Route('/', lambda request: PlainTextResponse('page')), WebSocketRoute('/', answer)]


def messages(host, token, scope, body=b''):
    """Return the messages with which a guarded page answers one request."""
    sent = []

    async def receive():
        kind = 'websocket.connect' if scope['type'] == 'websocket' else 'http.request'
        return {'type': kind, 'body': body}

    async def send(message):
        sent.append(message)

    asyncio.run(Guard(Starlette(routes=ROUTES), host, token)(scope, receive, send))
    return sent


def scope_of(kind='http', method='GET', query='', name='127.0.0.1:8080', **headers):
    headers = {'host': name, **{key.replace('_', '-'): text for key, text in headers.items()}}
    return {
        **{'type': kind, 'method': method, 'path': '/', 'query_string': query.encode()},
        'headers': [(name.encode(), value.encode()) for name, value in headers.items()],
    }


def ask(host='127.0.0.1', token='', **request):
    """Return the first message of the answer."""
    return messages(host, token, scope_of(**request))[0]


def is_let_in(**request):
    """Tell whether a page and a web socket are both let in; one alone fails."""
    page, socket = ask(**request), ask(kind='websocket', **request)
    assert page['status'] in (200, 403)
    assert (page['status'] == 200) == (socket['type'] == 'websocket.accept')
    return page['status'] == 200


def cookie_of(answer):
    """Return the cookie of a redirection to the page's own address, without the token."""
    headers = dict(answer['headers'])
    assert answer['status'] == 303
    assert headers[b'location'] == b'/'
    assert not any(TOKEN.encode() in text for text in headers.values())
    value, *rest = headers[b'set-cookie'].decode().split('; ')
    assert 'HttpOnly' in rest
    return value


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
def test_with_a_token_every_request_brings_what_it_gave(host):
    for query in ('', 'token=', 'token=wrong-token'):
        assert not is_let_in(host=host, token=TOKEN, query=query)
    for value in ('', TOKEN, 'wrong'):
        assert not is_let_in(host=host, token=TOKEN, cookie=f'{COOKIE}={value}')
    cookie = cookie_of(ask(host=host, token=TOKEN, query=f'token={TOKEN}'))
    assert is_let_in(host=host, token=TOKEN, cookie=cookie)
    assert not is_let_in(host=host, token='another-token', cookie=cookie)
    again = ask(host=host, token=TOKEN, cookie=cookie, query=f'token={TOKEN}')
    assert again['status'] == 303


def posted(body, **headers):
    headers = {'content_length': str(len(body)), **headers}
    return messages('0.0.0.0', TOKEN, scope_of(method='POST', **headers), body)


def test_a_browser_is_asked_for_the_token():
    shown = messages('0.0.0.0', TOKEN, scope_of(accept='text/html,*/*'))
    assert shown[0]['status'] == 403
    assert b'<form method="post"' in shown[1]['body']
    cookie = cookie_of(posted(f'token={TOKEN}'.encode())[0])
    assert is_let_in(host='0.0.0.0', token=TOKEN, cookie=cookie)
    wrong = posted(b'token=%FFwrong', accept='text/html')
    assert wrong[0]['status'] == 403
    assert posted(f'token={TOKEN}'.encode(), origin='http://example.org')[0]['status'] == 403


def test_a_large_body_is_not_read():
    assert posted(b'', content_length=str(LARGEST_BODY + 1))[0]['status'] == 413
    assert posted(b'', content_length='many')[0]['status'] == 413
    assert posted(b'', transfer_encoding='chunked')[0]['status'] == 413
    long = f'token={TOKEN}&rest={"x" * 2000}'.encode()
    assert posted(long)[0]['status'] == 403


def test_no_other_site_uses_the_page():
    assert is_let_in()
    assert is_let_in(origin='http://127.0.0.1:8080')
    assert not is_let_in(origin='http://example.org')
    cookie = cookie_of(ask(host='0.0.0.0', token=TOKEN, query=f'token={TOKEN}'))
    assert not is_let_in(host='0.0.0.0', token=TOKEN, cookie=cookie, origin='http://example.org')


def test_a_foreign_name_for_this_machine_is_refused():
    assert is_let_in(name='localhost:8080')
    assert not is_let_in(name='example.org:8080')
