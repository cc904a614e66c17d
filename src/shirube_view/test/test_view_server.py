"""The server with its node: access, driving by hand, and pages that send nonsense."""

import asyncio
import json
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
from aiohttp.test_utils import TestClient, TestServer
from geometry_msgs.msg import PoseStamped, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from node_testing import isolated_graph

from shirube_core.geometry import SE2
from shirube_ros.message_conversion import odometry_message
from shirube_ros.quality_of_service import map_profile
from shirube_view.bag_process import BagProcess
from shirube_view.commands.view import start_spinning
from shirube_view.view_node import ViewNode
from shirube_view.view_server import ViewServer

MISSION = Path(__file__).parents[3] / 'bags' / 'mission'


class Robot:
    """Node of the view in a thread, and what it publishes."""

    def __init__(self, context):
        self.node, self.velocities, self.goals = ViewNode(context=context), [], []
        self.node.create_subscription(TwistStamped, 'cmd_vel_in', lambda m: self.velocities.append(m.twist), 10)
        self.node.create_subscription(PoseStamped, 'goal_pose', self.goals.append, 10)
        self.thread = start_spinning(self.node)

    async def until(self, is_true):
        end = time.monotonic() + 20.0
        while not is_true():
            assert time.monotonic() < end
            await asyncio.sleep(0.01)


@pytest.fixture
def robot():
    with isolated_graph() as graph:
        robot = Robot(graph.context)
        yield robot
        graph.context.try_shutdown()
        robot.thread.join()
        robot.node.destroy_node()


def converse(robot, tmp_path, conversation, *tokens, bags=(), can_command=True):
    async def whole():
        server = ViewServer(robot.node, bags, BagProcess(tmp_path), tokens, can_command=can_command)
        async with TestClient(TestServer(server.application())) as client:
            await asyncio.wait_for(conversation(client), 100.0)

    asyncio.run(whole())


async def reply(socket, key):
    """Return the next message that has a key."""
    while True:
        message = json.loads(await socket.receive_str(timeout=20.0))
        if key in message:
            return message[key]


IMAGE = {'Sec-Fetch-Site': 'cross-site', 'Sec-Fetch-Mode': 'no-cors', 'Sec-Fetch-Dest': 'image'}


def test_other_sites_and_addresses_that_are_none_are_refused(robot, tmp_path):
    async def attack(client):
        for path in ('/', '/socket', '/static/main.js', '/static/mark.svg'):
            for headers in ({'Host': '['}, {'Host': 'elsewhere.example'}, {'Origin': 'http://x.example'}, IMAGE):
                assert (await client.get(path, headers=headers)).status == 403
        for path in ('/static/../view_server.py', '/static/%2e%2e/view_server.py', '/static/', '/bags', '/x'):
            assert (await client.get(path)).status in (403, 404)
        page = await client.get('/')
        assert page.status == 200
        assert "default-src 'self'" in page.headers['Content-Security-Policy']

    converse(robot, tmp_path, attack)


def test_without_a_token_nobody_sees_and_with_the_second_one_nobody_commands(robot, tmp_path):
    async def attack(client):
        for path in ('/', '/?token=wrong', '/?token=', '/socket', '/static/main.js'):
            assert (await client.get(path)).status == 403
        for token, key in (('watch', 'error'), ('command', 'said')):
            assert (await client.get(f'/?token={token}')).status == 200
            async with client.ws_connect('/socket') as socket:
                assert (await reply(socket, 'hello'))['may_command'] is (token == 'command')
                await socket.send_json({'do': 'goal', 'x': 1.0, 'y': 2.0, 'yaw': 0.0})
                await reply(socket, key)
        await robot.until(lambda: robot.goals)
        assert len(robot.goals) == 1

    converse(robot, tmp_path, attack, 'command', 'watch')


@pytest.mark.parametrize('how', ['closed', 'silent', 'let go'])
def test_the_robot_stops_without_its_driver(robot, tmp_path, how):
    async def drive(client):
        socket, other = await client.ws_connect('/socket'), await client.ws_connect('/socket')
        for _ in range(12):
            await socket.send_json({'do': 'drive', 'forward': 1.0, 'turn': -0.5})
            await asyncio.sleep(0.05)
        await other.send_json({'do': 'drive', 'forward': -1.0, 'turn': 0.0})
        assert 'another page drives' in await reply(other, 'error')
        await robot.until(lambda: robot.velocities)
        assert robot.velocities[0].linear.x > 0.0
        await socket.send_json({'do': 'drive', 'forward': 1.0, 'turn': -0.5})
        if how == 'closed':
            socket._response.connection.transport.abort()  # as a browser that is killed
        elif how == 'let go':
            await socket.send_json({'do': 'let_go'})
        await robot.until(lambda: robot.velocities[-1].linear.x == 0.0)
        count = len(robot.velocities)
        await robot.until(lambda: len(robot.velocities) > count + 3)
        assert {twist.linear.x for twist in robot.velocities[count:]} == {0.0}

    converse(robot, tmp_path, drive)


def nonsense(rng):
    """Return a random message: text, bytes, or almost a request."""
    kinds = ['drive', 'goal', 'initialpose', 'call', 'simulate', 'look', 'source', 'seek', 'speed', 'x', 7, None, []]
    values = [1e999, -1, 0.5, 'map', None, [], {}, True, '9' * 50, -1e400]
    if rng.uniform() < 0.2:
        return bytes(rng.integers(0, 128, 30, dtype=np.uint8)).decode()
    names = rng.choice(['x', 'y', 'yaw', 'forward', 'turn', 'name', 'what', 'camera', 'bag', 'time', 'pictures'], 4)
    request = {str(name): values[rng.integers(len(values))] for name in names}
    return json.dumps({'do': kinds[rng.integers(len(kinds))], **request})


def test_ten_thousand_random_messages_neither_end_the_server_nor_move_the_robot(robot, tmp_path, caplog):
    async def attack(client):
        rng = np.random.default_rng(2)
        async with client.ws_connect('/socket') as socket:

            async def listen():
                async for _ in socket:
                    pass

            listening = asyncio.create_task(listen())
            for number in range(10_000):
                await socket.send_str(nonsense(rng))
                if number % 100 == 0:
                    await socket.send_bytes(b'\0' * number)
                    await asyncio.sleep(0)
            listening.cancel()
        async with client.ws_connect('/socket') as socket:
            for text in ('[' * 30_000, '{"do": "drive", "forward": 2, "turn": 0}', '{"do": "seek", "time": 1}'):
                await socket.send_str(text)
                error = await reply(socket, 'error')
                assert error.count('\n') == 0
                assert 'internal' not in error
        async with client.ws_connect('/socket') as socket:
            await socket.send_str('x' * 100_000)
            while not socket.closed:
                await socket.receive()
        assert (await client.get('/')).status == 200

    converse(robot, tmp_path, attack)
    assert 'internal error' not in caplog.text
    assert all(abs(twist.linear.x) <= 0.3 for twist in robot.velocities)


def test_a_page_plays_a_bag_and_jumps_in_it(robot, tmp_path):
    async def watch(client):
        async with client.ws_connect('/socket') as socket:
            assert (await reply(socket, 'hello'))['bags'] == ['mission']
            assert (await reply(socket, 'status'))['length'] == pytest.approx(76.6, abs=0.1)
            await socket.send_json({'do': 'seek', 'time': 60.0})
            await socket.send_json({'do': 'speed', 'speed': 0})
            await reply(socket, 'cleared')
            while 'map' not in (values := await reply(socket, 'values')):
                pass
            assert {'map', 'plan', 'fused'} <= set(values)
            assert await reply(socket, 'time') == pytest.approx(60.0, abs=1.0)

    converse(robot, tmp_path, watch, bags=[MISSION])


CHROMIUM = shutil.which('chromium')
PLACE = SE2(1.0, 2.0, 0.5)
NAMELESS = """() => [...document.querySelectorAll('button, a, select, input, canvas, output, [tabindex]')]
    .filter((e) => !(e.ariaLabel || e.title || e.labels?.length || e.textContent.trim())).map((e) => e.outerHTML)"""
PIXEL = """([x, y]) => { const map = document.getElementById('map'), [px, py] = window.__view.onPage(x, y);
    const box = map.getBoundingClientRect(), paint = map.getContext('2d');
    return [...paint.getImageData(px - box.left, py - box.top, 1, 1).data].slice(0, 3); }"""


def feed(node):
    """Publish a map of 4 x 3 m with a wall on its left, and the fused pose of a robot."""
    grid = OccupancyGrid(data=[100, *[0] * 7] * 6)
    grid.header.frame_id = 'map'
    grid.info.resolution, grid.info.width, grid.info.height = 0.5, 8, 6
    node.create_publisher(OccupancyGrid, 'reward_planner/map', map_profile()).publish(grid)
    fused = node.create_publisher(Odometry, 'pose_arbiter/odometry', 10)
    pose = odometry_message(PLACE, np.diag((1e-4, 1e-4, 1e-4)), grid.header, 'base_link')
    node.create_timer(0.05, lambda: fused.publish(pose))


async def use_page(robot, page, address):
    """Look at the map and the names of all controls, and hold a key."""

    async def wait(expression):
        end = time.monotonic() + 40.0
        while not await page.evaluate(expression):
            assert time.monotonic() < end, expression
            await asyncio.sleep(0.05)

    await page.goto(address)
    await wait('window.__view?.robot()?.x === 1 && window.__view.state.grids.map?.width === 8')
    await asyncio.sleep(0.3)  # it is drawn with the next frame of the browser
    wall, free, itself = [await page.evaluate(PIXEL, place) for place in ((0.25, 1.0), (3.0, 0.5), (1.0, 2.0))]
    assert len({tuple(colour) for colour in (wall, free, itself)}) == 3
    assert await page.evaluate(NAMELESS) == []
    await page.get_by_test_id('stick').focus()
    await page.keyboard.down('ArrowUp')
    await robot.until(lambda: len(robot.velocities) > 5)
    assert robot.velocities[-1].linear.x > 0.0


@pytest.mark.skipif(CHROMIUM is None, reason='the page is tested in chromium: apt-get install chromium')
def test_the_browser_shows_the_robot_and_stops_it_when_the_page_is_closed(robot, tmp_path):
    playwright = pytest.importorskip('playwright.async_api', reason='pip install playwright')
    robot.node.run_soon(lambda: feed(robot.node))

    async def drive(client):
        async with playwright.async_playwright() as started:
            browser = await started.chromium.launch(executable_path=CHROMIUM, args=['--no-sandbox'])
            page, faults = await browser.new_page(), []
            page.on('pageerror', lambda fault: faults.append(str(fault)))
            await use_page(robot, page, str(client.make_url('/')))
            await page.close()
            await robot.until(lambda: robot.velocities[-1].linear.x == 0.0)
            count = len(robot.velocities)
            await robot.until(lambda: len(robot.velocities) > count + 3)
            assert {twist.linear.x for twist in robot.velocities[count:]} == {0.0}
            assert faults == []
            await browser.close()

    converse(robot, tmp_path, drive)
