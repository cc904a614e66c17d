"""Web server of the teaching page: static files, images and one WebSocket for requests."""

import asyncio
import json
import logging
from collections.abc import Hashable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

from aiohttp import WSMsgType, web

from shirube_ros.errors import CameraFileError
from shirube_ros.web.access import access_middleware
from stereo_landmark.core.stereo_landmark_error import StereoLandmarkError
from stereo_landmark.files.camera_files import encode_png
from stereo_landmark.page.request_handler import RequestHandler

_LOG = logging.getLogger(__name__)
_MESSAGE_MAX = 1 << 20
"""Maximum size of a request [bytes]."""


class PageServer:
    """Serves one session to any number of pages, which all show the same state.

    Args:
        answers: handler of the pages' requests.
        token: access token, empty for access from this machine only.
    """

    def __init__(self, answers: RequestHandler, token: str = '') -> None:
        self.answers = answers
        self._token = token
        # One worker: the session is not thread-safe, and requests keep their order.
        self._worker = ThreadPoolExecutor(max_workers=1)
        # State last sent to each page.
        self._pages: dict[web.WebSocketResponse, Hashable] = {}

    def application(self) -> web.Application:
        """Return the aiohttp application."""
        application = web.Application(middlewares=[access_middleware(self._token)])
        application.router.add_get('/', self._page)
        application.router.add_get('/socket', self._socket)
        application.router.add_get(r'/image/{pair:\d{1,9}}/{side:left|right}.png', self._image)
        application.router.add_static('/static/', _static_folder())
        application.on_shutdown.append(self._close)
        return application

    async def _page(self, _: web.Request) -> web.StreamResponse:
        return web.FileResponse(_static_folder() / 'index.html')

    async def _image(self, request: web.Request) -> web.StreamResponse:
        pair, side = int(request.match_info['pair']), request.match_info['side']

        def picture() -> bytes:
            return encode_png(getattr(self.answers.images(pair), side))

        try:
            body = await self._run_in_worker(picture)
        except (StereoLandmarkError, CameraFileError) as fault:
            raise web.HTTPNotFound(text=str(fault)) from fault
        return web.Response(body=body, content_type='image/png')

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        socket = web.WebSocketResponse(max_msg_size=_MESSAGE_MAX, heartbeat=20.0, compress=False)
        await socket.prepare(request)
        self._pages[socket] = self.answers.display_state
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    await self._answer(socket, message.data)
        except ConnectionResetError:
            pass  # the page was closed before the response
        finally:
            del self._pages[socket]
            await self._notify_pages()
        return socket

    async def _answer(self, socket: web.WebSocketResponse, text: str) -> None:
        try:
            request = json.loads(text)
        except (ValueError, RecursionError):
            request = None
        if not isinstance(request, dict):
            await socket.send_json({'error': 'request: must be a JSON object; reload the page'})
            return
        try:
            answer, shown = await self._run_in_worker(
                lambda: (self.answers.answer(request), self.answers.display_state)
            )
        except Exception:  # noqa: BLE001 as in a node's callbacks
            # A failing request must not end a session with unsaved changes.
            _LOG.exception('internal error while handling a request')
            shown = self._pages[socket]
            answer = {'error': 'internal error, see the log of teach; save the place and report it to the maintainer'}
        await socket.send_json({'id': request.get('id'), **answer})
        # Other pages are not updated during a drag; the page requests the whole state at its end.
        if request.get('do') != 'edges':
            self._pages[socket] = shown
            await self._notify_pages()

    async def _notify_pages(self) -> None:
        """Notify the pages whose state is outdated.

        Responses may be sent out of order, so pages that received an older state since are notified, too.
        """
        shown = self.answers.display_state
        for page, known in list(self._pages.items()):
            if known != shown:
                self._pages[page] = shown
                with suppress(ConnectionResetError):
                    await page.send_json({'changed': True})

    async def _run_in_worker(self, work: Any) -> Any:
        return await asyncio.get_running_loop().run_in_executor(self._worker, work)

    async def _close(self, _: web.Application) -> None:
        for socket in list(self._pages):
            await socket.close()
        self._worker.shutdown(wait=False, cancel_futures=True)


def _static_folder() -> Path:
    with as_file(files('stereo_landmark.page') / 'static') as folder:
        return folder
