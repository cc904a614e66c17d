"""Web server of the live page: static files and one WebSocket for each page."""

import asyncio
import json
import logging
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from importlib.resources import as_file, files
from pathlib import Path
from time import monotonic
from typing import Any

from aiohttp import WSMsgType, web

from shirube_bags.errors import BagError
from shirube_ros.web.access import access_middleware, role_of
from shirube_view.bag_process import BagProcess
from shirube_view.board import Board, Seen
from shirube_view.channels import CHANNELS, Kind
from shirube_view.recording import Recording
from shirube_view.requests import KINDS, Commands, RequestError, number
from shirube_view.view_node import ViewNode

_LOG = logging.getLogger(__name__)
_PERIOD, _STATUS_PERIOD, _PICTURE_PERIOD = 0.05, 1.0, 0.2
"""Periods of updates, of rates and states, and of pictures [s]."""
_MESSAGE_MAX, _SPEED_MAX, _TIME_MAX = 1 << 16, 20.0, 1e7
PICTURES = tuple(channel.name for channel in CHANNELS if channel.kind is Kind.PICTURE)
_VALUES = frozenset(channel.name for channel in CHANNELS) - frozenset(PICTURES)


class Page:
    """One open page.

    Attributes:
        seen: what it has already.
        recording: bag that it plays, None if it is live.
        may_command: whether it may command the robot.
        is_waiting: whether it plays a bag only until a robot is live.
    """

    def __init__(self, socket: web.WebSocketResponse, live: Board, *, may_command: bool) -> None:
        """Start with live messages."""
        self.socket, self.may_command = socket, may_command
        self.seen = Seen()
        self.recording: Recording | None = None
        self.is_waiting = False
        self.lock = asyncio.Lock()  # a jump in the time line must not be disturbed by an update
        self._live, self._loop = live, asyncio.get_running_loop()
        self._counts: Counter[str] = Counter()
        self._pictures_at = self._advanced_at = monotonic()

    def report(self, text: str, is_done: bool) -> None:
        """Send a line to the page, from any thread."""
        message = {'said' if is_done else 'error': text}
        asyncio.run_coroutine_threadsafe(self._send(json.dumps(message)), self._loop)

    async def _send(self, text: str) -> None:
        with suppress(ConnectionResetError):
            await self.socket.send_str(text)

    async def show(self, recording: Recording | None) -> None:
        """Show a bag from now on, or what is live."""
        if self.recording is not None and recording is not self.recording:
            self.recording.close()
        self.recording, self.seen = recording, Seen(pictures=self.seen.pictures)
        self._counts.clear()
        await self._send('{"cleared":true}')

    async def update(self) -> None:
        """Send what is new."""
        now, seen = monotonic(), self.seen
        elapsed, self._advanced_at = now - self._advanced_at, now
        board, clock = self._live, ''
        if self.recording is not None:
            self.recording.advance(elapsed)
            board, clock = self.recording.board, f'"time":{self.recording.time:.3f},'
        board.update()
        news = board.news(seen)
        pictures = []
        if now - self._pictures_at >= _PICTURE_PERIOD:
            self._pictures_at = now
            pictures = await asyncio.to_thread(lambda: list(board.pictures(seen)))
            seen.picture_version = board.version
        seen.version = board.version
        if news or clock:
            await self._send(f'{{{clock}"values":{{{news}}}}}')
        for name, picture in pictures:
            await self.socket.send_bytes(bytes([PICTURES.index(name)]) + picture)

    def rates(self) -> dict[str, int]:
        """Return how many messages of each channel arrived since the last call."""
        counts = (self._live if self.recording is None else self.recording.board).counts
        rates = {name: count - self._counts[name] for name, count in counts.items()}
        self._counts = counts.copy()
        return rates


class ViewServer:
    """Serves the live page.

    Args:
        node: node that subscribes and publishes.
        bags: bags that pages can play; if any is given, pages begin with the first.
        tokens: tokens of those who command, and of those who only watch; empty for access from this machine only.
        can_command: whether anybody may command the robot.
        recorder: records bags.
        progress: returns a line about what is being prepared, empty for none.
    """

    def __init__(
        self,
        node: ViewNode,
        bags: Sequence[Path],
        recorder: BagProcess,
        tokens: Sequence[str] = (),
        *,
        can_command: bool = True,
        progress: Callable[[], str] = str,
    ) -> None:
        self._node, self._bags, self._tokens, self._recorder = node, bags, tokens, recorder
        self._commands = Commands(node, recorder)
        self._can_command, self._progress = can_command, progress
        self._pages: dict[web.WebSocketResponse, Page] = {}

    def application(self) -> web.Application:
        """Return the aiohttp application."""
        application = web.Application(middlewares=[access_middleware(*self._tokens)])
        application.router.add_get('/', self._index)
        application.router.add_get('/socket', self._socket)
        application.router.add_static('/static/', static_folder())
        application.on_shutdown.append(self._close)
        return application

    async def _index(self, _: web.Request) -> web.StreamResponse:
        return web.FileResponse(static_folder() / 'index.html')

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        socket = web.WebSocketResponse(max_msg_size=_MESSAGE_MAX, heartbeat=5.0, compress=False)
        await socket.prepare(request)
        is_watcher = bool(self._tokens) and role_of(request, self._tokens) != 0
        page = Page(socket, self._node.board, may_command=self._can_command and not is_watcher)
        self._pages[socket] = page
        sending = asyncio.create_task(self._send_updates(page))
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    await self._answer(page, message.data)
        except ConnectionResetError:
            pass  # the page was closed before the response
        finally:
            self._node.driver.release(page, monotonic())
            sending.cancel()
            del self._pages[socket]
            self._watch()
            if page.recording is not None:
                page.recording.close()
        return socket

    async def _send_updates(self, page: Page) -> None:
        with suppress(ConnectionResetError):
            hello = {'bags': [bag.name for bag in self._bags], 'pictures': PICTURES, 'may_command': page.may_command}
            await page.socket.send_json({'hello': hello})
            page.is_waiting = bool(self._bags)
            await self._open(page, 0)
            status_at = 0.0
            while True:
                if (now := monotonic()) - status_at >= _STATUS_PERIOD:
                    status_at = now
                    await page.socket.send_json({'status': self._status(page)})
                if page.is_waiting and self._node.board.counts['fused']:
                    page.is_waiting = False
                    await self._open(page, len(self._bags))
                    await page.socket.send_json({'live': True})
                async with page.lock:
                    await page.update()
                await asyncio.sleep(_PERIOD)

    def _status(self, page: Page) -> dict[str, Any]:
        recording = page.recording
        return {
            'rates': page.rates(),
            'is_simulated': self._node.is_simulated,
            'is_recording': self._recorder.is_running,
            'progress': self._progress(),
            'length': None if recording is None else recording.length,
            'speed': None if recording is None else recording.speed,
        }

    def _watch(self) -> None:
        """Subscribe to what live pages show."""
        live = [page for page in self._pages.values() if page.recording is None]
        pictures = frozenset(name for page in live for name in page.seen.pictures)
        is_any_waiting = any(page.is_waiting for page in self._pages.values())
        self._node.watched = (_VALUES | pictures) if live else {'fused'} if is_any_waiting else frozenset()

    async def _answer(self, page: Page, text: str) -> None:
        try:
            request = json.loads(text)
        except (ValueError, RecursionError):
            request = None
        try:
            if not isinstance(request, dict) or not isinstance(request.get('do'), str):
                raise RequestError('a request must be a JSON object; reload the page')
            said = await self._do(page, request)
            if said:
                page.report(said, is_done=True)
        except (RequestError, BagError, OSError) as fault:
            page.report(str(fault), is_done=False)
        except Exception:  # noqa: BLE001 as in a node's callbacks
            _LOG.exception('internal error while handling a request')
            page.report('internal error, see the log of view', is_done=False)

    async def _do(self, page: Page, request: Mapping[str, Any]) -> str:
        kind, recording = request['do'], page.recording
        if kind in KINDS:
            if not page.may_command:
                raise RequestError('this page may only watch; open the address for commands')
            return self._commands.do(page, request)
        if kind == 'look':
            names = request.get('pictures')
            page.seen.pictures = [name for name in PICTURES if isinstance(names, list) and name in names]
            self._watch()
        elif kind == 'source':
            page.is_waiting = False
            await self._open(page, round(number(request, 'bag', len(self._bags))))
        elif recording is None:
            raise RequestError('no bag is open; choose one first')
        elif kind == 'speed':
            recording.speed = max(0.0, number(request, 'speed', _SPEED_MAX))
        elif kind == 'seek':
            time = number(request, 'time', _TIME_MAX)
            async with page.lock:
                await asyncio.to_thread(recording.seek, time)
                await page.show(recording)
        else:
            raise RequestError('this request is not known; reload the page')
        return ''

    async def _open(self, page: Page, index: int) -> None:
        """Show a bag, or what is live if the index is none."""
        bag = self._bags[index] if 0 <= index < len(self._bags) else None
        async with page.lock:
            await page.show(None if bag is None else await asyncio.to_thread(Recording, bag))
        self._watch()

    async def _close(self, _: web.Application) -> None:
        for socket in list(self._pages):
            await socket.close()
        self._recorder.close()


def static_folder() -> Path:
    """Return the folder of the page."""
    with as_file(files('shirube_view') / 'static') as folder:
        return folder
