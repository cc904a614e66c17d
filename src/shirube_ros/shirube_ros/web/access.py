"""Access control of pages: open on this machine, with a token from elsewhere."""

import hashlib
import hmac
import ipaddress
import secrets
import socket
from collections.abc import Awaitable, Callable, Sequence
from urllib.parse import urlsplit

from aiohttp import web

_HEADERS = {
    'Content-Security-Policy': "default-src 'self'; img-src 'self' data:; connect-src 'self'; base-uri 'none'; "
    "frame-ancestors 'none'",
    'Cross-Origin-Resource-Policy': 'same-origin',
    'X-Content-Type-Options': 'nosniff',
    'Cache-Control': 'no-cache',
}

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def is_loopback(host: str) -> bool:
    """Return whether a host name or address is a loopback address."""
    if host == 'localhost':
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def new_token() -> str:
    """Return a random token."""
    return secrets.token_urlsafe(16)


def access_middleware(*tokens: str) -> Callable[..., Awaitable[web.StreamResponse]]:
    """Return the middleware that rejects unauthorized requests.

    Without a token only requests to a loopback host are accepted, which prevents DNS rebinding; cross-site requests are
    always rejected.

    Args:
        tokens: one of them must be given once in the address; an empty one counts for none.
    """
    tokens = tuple(filter(None, tokens))

    @web.middleware
    async def check(request: web.Request, handler: Handler) -> web.StreamResponse:
        _reject_cross_site(request)
        if not tokens:
            if not is_loopback(_host_name(request)):
                raise web.HTTPForbidden(text='this page is for 127.0.0.1; give --host to open it to others')
        elif 'token' in request.query or role_of(request, tokens) is None:
            raise _login_response(request, tokens)
        response = await handler(request)
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    return check


def role_of(request: web.Request, tokens: Sequence[str]) -> int | None:
    """Return the index of the token with which a page was opened, None for none of them."""
    given = request.cookies.get(_cookie_name(tokens[0]), '')
    return next((index for index, token in enumerate(tokens) if _is_valid_token(given, token)), None)


def _cookie_name(token: str) -> str:
    """Return a unique cookie name per server, because cookies are shared by all ports of a host."""
    return f'shirube_token_{hashlib.sha256(token.encode()).hexdigest()[:8]}'


def _reject_cross_site(request: web.Request) -> None:
    # Cross-site image requests have no Origin, only Sec-Fetch-Site. Links to the page itself are accepted.
    is_cross_site = request.headers.get('Sec-Fetch-Site') in ('cross-site', 'same-site')
    if is_cross_site and request.headers.get('Sec-Fetch-Mode') != 'navigate':
        raise web.HTTPForbidden(text='this page answers its own scripts only')
    origin = request.headers.get('Origin')
    try:
        is_same_origin = origin is None or urlsplit(origin).netloc == request.host
    except ValueError:
        is_same_origin = False
    if not is_same_origin:
        raise web.HTTPForbidden(text='this page answers its own scripts only')


def _host_name(request: web.Request) -> str:
    """Return the requested host name, empty if it is invalid."""
    try:
        return urlsplit(f'//{request.host}').hostname or ''
    except ValueError:
        return ''


def _login_response(request: web.Request, tokens: tuple[str, ...]) -> web.HTTPException:
    given = request.query.get('token', '')
    if not any(_is_valid_token(given, token) for token in tokens):
        return web.HTTPForbidden(text='give the token: open the address that the command printed')
    response = web.HTTPFound('/')
    response.set_cookie(_cookie_name(tokens[0]), given, httponly=True, samesite='Strict')
    return response


def _is_valid_token(candidate: str, token: str) -> bool:
    # Bytes that are not valid text arrive as lone surrogates.
    return hmac.compare_digest(candidate.encode(errors='surrogateescape'), token.encode())


_DOCUMENTATION_ADDRESSES = {4: '192.0.2.1', 6: '2001:db8::1'}
"""Documentation addresses: nothing is sent, but the route to them determines this machine's own address."""


def reachable_host(host: str) -> str:
    """Return the host part of the page's address.

    Args:
        host: listening address; an unspecified address is replaced by this machine's own address.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    shown = _own_address(address.version) if address.is_unspecified else host
    return f'[{shown}]' if ':' in shown else shown


def _own_address(version: int) -> str:
    family = socket.AF_INET if version == 4 else socket.AF_INET6
    try:
        with socket.socket(family, socket.SOCK_DGRAM) as probe:
            probe.connect((_DOCUMENTATION_ADDRESSES[version], 9))
            return str(probe.getsockname()[0])
    except OSError:
        return '127.0.0.1' if version == 4 else '::1'
