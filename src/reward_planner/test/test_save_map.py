"""The command calls the service and prints its response."""

import pytest
from std_srvs.srv import Trigger

from reward_planner.commands import save_map


@pytest.mark.parametrize(
    ('answer', 'code', 'out', 'err'),
    [
        (Trigger.Response(success=True, message='saved to room.yaml'), 0, 'saved to room.yaml\n', ''),
        (Trigger.Response(success=False, message='nothing is known'), 1, '', 'save_map: nothing is known\n'),
        (None, 1, '', 'save_map: /robot/planner does not respond; start it first\n'),
    ],
)
def test_the_answer_of_the_node_is_reported(answer, code, out, err, monkeypatch, capsys):
    asked = []
    monkeypatch.setattr(save_map, 'call', lambda service: asked.append(service) or answer)
    assert save_map.main(['--node', '/robot/planner']) == code
    assert asked == ['/robot/planner/save_map']
    assert tuple(capsys.readouterr()) == (out, err)
