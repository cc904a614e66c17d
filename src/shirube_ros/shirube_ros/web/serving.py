"""The main loop of a page's server."""

import asyncio
import logging
import signal
from typing import Any, Protocol

from aiohttp import web


class Server(Protocol):
    """A server of a page."""

    def application(self) -> web.Application:
        """Return the aiohttp application."""


def serve(server: Server, host: str, port: int, on_ready: Any) -> None:
    """Serve until SIGINT or SIGTERM.

    Args:
        server: page server, whose application is served.
        host: address to listen on.
        port: port to listen on, 0 for any free port.
        on_ready: callback with the actual port.

    Raises:
        OSError: the port is in use, or the address does not belong to this machine.
    """
    logging.getLogger('aiohttp.access').setLevel(logging.WARNING)
    asyncio.run(_serve(server, host, port, on_ready))


async def _serve(server: Server, host: str, port: int, on_ready: Any) -> None:
    runner = web.AppRunner(server.application(), shutdown_timeout=1.0)
    await runner.setup()
    try:
        await web.TCPSite(runner, host, port).start()
        on_ready(runner.addresses[0][1])
        end = asyncio.Event()
        for each in (signal.SIGINT, signal.SIGTERM):
            asyncio.get_running_loop().add_signal_handler(each, end.set)
        await end.wait()
    finally:
        await runner.cleanup()
