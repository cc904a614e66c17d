import ipaddress

import pytest

from shirube_ros.web.access import is_loopback, reachable_host


@pytest.mark.parametrize(
    ('host', 'expected'),
    [('127.0.0.1', True), ('localhost', True), ('::1', True), ('0.0.0.0', False), ('robot.local', False)],
)
def test_only_this_machine_is_loopback(host, expected):
    assert is_loopback(host) is expected


@pytest.mark.parametrize(
    ('host', 'shown'), [('127.0.0.1', '127.0.0.1'), ('::1', '[::1]'), ('robot.local', 'robot.local')]
)
def test_an_address_is_shown_as_a_browser_takes_it(host, shown):
    assert reachable_host(host) == shown


@pytest.mark.parametrize('host', ['0.0.0.0', '::'])
def test_all_addresses_are_shown_as_one_that_can_be_opened(host):
    shown = ipaddress.ip_address(reachable_host(host).strip('[]'))
    assert not shown.is_unspecified
