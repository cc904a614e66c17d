"""The web server: one session for all pages, and access control."""

import asyncio
import inspect

import pytest
from aiohttp.test_utils import TestClient, TestServer
from teaching_wall import pairs_of_wall

from stereo_landmark.page.page_server import PageServer
from stereo_landmark.page.place_saver import PlaceSaver
from stereo_landmark.page.request_handler import RequestHandler


def talking(token=''):
    """Run a test, given a client, against a new server."""

    def decorate(conversation):
        def test(tmp_path, **fixtures):
            async def whole():
                server = PageServer(RequestHandler(pairs_of_wall(), PlaceSaver(tmp_path)), token)
                async with TestClient(TestServer(server.application())) as client:
                    await asyncio.wait_for(conversation(client, **fixtures), 110.0)

            asyncio.run(whole())

        _, *fixtures = inspect.signature(conversation).parameters  # the client, then what pytest gives
        names = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in ('tmp_path', *fixtures)]
        test.__signature__ = inspect.Signature(names)
        return test

    return decorate


async def ask(socket, **request):
    """Send a request and return the response."""
    await socket.send_json(request)
    return await socket.receive_json()


@talking()
async def test_the_page_its_files_and_its_images_are_there(client):
    page = await client.get('/')
    assert 'Teach a place' in await page.text()
    assert "default-src 'self'" in page.headers['Content-Security-Policy']
    for name in ('main.js', 'page.css', 'mark.svg'):
        assert (await client.get(f'/static/{name}')).status == 200
    image = await client.get('/image/1/right.png')
    assert (await image.read()).startswith(b'\x89PNG')
    assert image.headers['Cross-Origin-Resource-Policy'] == 'same-origin'
    assert image.headers['X-Content-Type-Options'] == 'nosniff'


@talking()
async def test_pages_see_the_steps_of_each_other(client):
    async with client.ws_connect('/socket') as one, client.ws_connect('/socket') as two:
        answer = await ask(one, id=7, do='rename_place', name='hall')
        assert (answer['id'], answer['state']['place']) == (7, 'hall')
        assert await two.receive_json() == {'changed': True}
        assert (await ask(two, do='snapshot'))['state']['place'] == 'hall'


@talking()
async def test_an_answer_from_before_a_step_of_another_page_is_followed_by_news(client, monkeypatch):
    """Both responses are computed before either is sent, and the older one is sent first."""
    in_worker = PageServer._run_in_worker
    found, sent = ([asyncio.Event(), asyncio.Event()] for _ in range(2))

    async def held(server, work):
        answer = await in_worker(server, work)
        number = sum(each.is_set() for each in found)
        found[number].set()
        await sent[number].wait()
        return answer

    monkeypatch.setattr(PageServer, '_run_in_worker', held)
    async with client.ws_connect('/socket') as one, client.ws_connect('/socket') as two:
        await two.send_json({'id': 1, 'do': 'snapshot'})
        await found[0].wait()
        await one.send_json({'id': 2, 'do': 'rename_place', 'name': 'hall'})
        await found[1].wait()
        sent[0].set()
        assert (await two.receive_json())['state']['place'] != 'hall'
        sent[1].set()
        assert await two.receive_json(timeout=5.0) == {'changed': True}
        monkeypatch.setattr(PageServer, '_run_in_worker', in_worker)


@talking()
async def test_other_pages_are_notified_of_a_slider_after_the_drag(client):
    async with client.ws_connect('/socket') as one, client.ws_connect('/socket') as two:
        for value in (7.0, 8.0):
            fields = {'name': 'edges.threshold', 'value': value, 'gesture': 'a', 'sides': []}
            assert 'edges' in await ask(one, do='edges', **fields)
        with pytest.raises(asyncio.TimeoutError):
            await two.receive_json(timeout=0.05)
        await ask(one, do='snapshot')
        assert await two.receive_json() == {'changed': True}
        assert (await ask(two, do='snapshot'))['state']['processing']['edges.threshold'] == 8.0
        with pytest.raises(asyncio.TimeoutError):
            await one.receive_json(timeout=0.05)


@talking()
async def test_nonsense_is_answered_and_the_server_goes_on(client):
    async with client.ws_connect('/socket') as socket:
        deep = '[' * 200_000
        for nonsense in ('{', '[]', '7', '"x"', '{"do": {}}', deep, f'{{"id": {"9" * 5000}}}'):
            await socket.send_str(nonsense)
            assert 'error' in await socket.receive_json()
        assert 'configuration' in await ask(socket, do='hello')


@talking()
async def test_a_fault_of_the_program_ends_no_session(client, monkeypatch, caplog):
    def fault(*_):
        raise ZeroDivisionError

    monkeypatch.setattr(RequestHandler, 'answer', fault)
    async with client.ws_connect('/socket') as socket:
        for number in (1, 2):
            answer = await ask(socket, id=number, do='hello')
            assert answer['id'] == number
            assert 'internal error' in answer['error']
    assert 'ZeroDivisionError' in caplog.text


IMAGE = '/image/0/left.png'
SHOWN = {'Sec-Fetch-Site': 'cross-site', 'Sec-Fetch-Mode': 'no-cors', 'Sec-Fetch-Dest': 'image'}
LINK = {'Sec-Fetch-Site': 'cross-site', 'Sec-Fetch-Mode': 'navigate', 'Sec-Fetch-Dest': 'document'}


@pytest.mark.parametrize(
    ('path', 'headers', 'status'),
    [
        ('/', {'Host': '['}, 403),
        ('/', {'Host': 'elsewhere.example'}, 403),
        ('/', {'Origin': 'http://['}, 403),
        ('/', LINK, 200),
        ('/socket', {'Origin': 'http://elsewhere.example'}, 403),
        ('/static/../page_server.py', {}, 404),
        ('/image/2/left.png', {}, 404),
        (f'/image/{"9" * 5000}/left.png', {}, 404),
        (IMAGE, SHOWN, 403),
        (IMAGE, {**SHOWN, 'Sec-Fetch-Site': 'same-origin'}, 200),
    ],
)
@talking()
async def test_other_sites_and_addresses_that_are_none_are_refused(client, path, headers, status):
    assert (await client.get(path, headers=headers)).status == status


@talking('secret')
async def test_a_cookie_that_is_no_text_is_no_token(client):
    where = client.make_url('/')
    reader, writer = await asyncio.open_connection(where.host, where.port)
    writer.write(b'GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: shirube_token=\xff\xfe\r\n\r\n')
    assert b' 403 ' in await reader.readline()
    writer.close()


def test_a_cookie_is_for_one_server_and_not_for_scripts_and_other_sites(tmp_path):
    names = set()
    for token in ('one', 'other'):

        async def enter(client, token=token):
            way_in = await client.get(f'/?token={token}', allow_redirects=False)
            (cookie,) = way_in.cookies.values()
            assert (bool(cookie['httponly']), cookie['samesite']) == (True, 'Strict')
            assert way_in.headers['Location'] == '/'
            names.add(cookie.key)

        talking(token)(enter)(tmp_path)
    assert len(names) == 2


@talking('secret')
async def test_requests_without_the_token_are_rejected(client):
    for path in ('/', '/?token=wrong', '/static/main.js', IMAGE, '/socket'):
        assert (await client.get(path)).status == 403
    for path in ('/?token=secret', IMAGE):
        assert (await client.get(path)).status == 200
    async with client.ws_connect('/socket') as socket:
        assert 'state' in await ask(socket, do='hello')
