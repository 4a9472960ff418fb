import re
import signal

import pytest

from mctrack_ros.cli.live import run_to_end
from mctrack_ros.ros.graph.graph import player_node


@pytest.fixture
def own_handler():
    """Take back what `run_to_end` lets a signal do."""
    handler = signal.getsignal(signal.SIGTERM)
    yield
    signal.signal(signal.SIGTERM, handler)


@pytest.mark.live
@pytest.mark.xdist_group('live')
@pytest.mark.usefixtures('own_handler')
def test_a_graph_that_fails_says_which_process_did_and_where_it_says_why(tmp_path):
    log = tmp_path / 'graph.log'
    said = re.escape(f'[player] failed with 2: see {log}')
    with pytest.raises(OSError, match=said):
        run_to_end([player_node(tmp_path / 'missing')], log, None)
    assert str(tmp_path / 'missing') in log.read_text()
