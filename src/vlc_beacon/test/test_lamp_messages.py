"""Text and bytes of lamps on the topic ``~/data``, in the diagnostics and in the table of ``locate``."""

import json
from dataclasses import replace
from pathlib import Path

from beacon_robot import Robot
from node_testing import IsolatedGraph
from receptions import LAMPS, with_fix
from std_msgs.msg import String

from vlc_beacon.commands.locate import LocatedImage, save_messages

SENDER = LAMPS[0].beacon
GREETING = replace(LAMPS[0], message='診察室 "3"')
UNCONFIRMED = replace(LAMPS[0], beacon=None, message=b'\x00\xff')


def test_a_received_message_is_published_and_reported(graph: IsolatedGraph, tmp_path: Path) -> None:
    (tmp_path / 'beacons.yaml').write_text('beacons: [{id: 1, xyz: [0, 0, 2.5], radius: 0.03}]')
    robot = Robot(graph, tmp_path / 'beacons.yaml')
    data = robot.listen(String, 'data')
    robot.receiver.answer = replace(with_fix(), lamps=(GREETING, UNCONFIRMED))
    robot.send_image()
    robot.wait_for(data, 2)
    assert [json.loads(message.data) for message in data] == [
        {'beacon': SENDER, 'text': '診察室 "3"'},
        {'beacon': None, 'bytes': '00ff'},
    ]
    assert '診察室' in data[0].data
    values = {value.key: value.value for value in robot.report().values}
    assert values[f'lamp {SENDER} message'] == repr(GREETING.message)


def test_locate_writes_messages_with_stamp_and_sender(tmp_path: Path) -> None:
    images = [
        LocatedImage('a', 1_500_000_000, replace(with_fix(), lamps=(GREETING, LAMPS[0]))),
        LocatedImage('b', 1_600_000_000, 'damaged'),
        LocatedImage('c', 1_700_000_000, replace(with_fix(), lamps=(UNCONFIRMED,))),
    ]
    assert save_messages(tmp_path / 'data.csv', images) == 2
    lines = (tmp_path / 'data.csv').read_text().splitlines()
    assert lines[0] == 'stamp,beacon,data'
    assert lines[1].startswith(f'1.500000000,{SENDER},')
    assert lines[2] == '1.700000000,,"{""beacon"": null, ""bytes"": ""00ff""}"'
