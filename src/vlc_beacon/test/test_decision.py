import json

from vlc_beacon.core.authorization.decision import Accepted
from vlc_beacon.core.packet.command_packet import Command, Operation


def test_the_topic_s_text_names_beacon_counter_op_and_value() -> None:
    text = Accepted(Command(3, Operation.SPEED_UP, 0.8, 17)).to_json()
    assert json.loads(text) == {'beacon': 3, 'counter': 17, 'op': 'speed_up', 'value': 0.8}
