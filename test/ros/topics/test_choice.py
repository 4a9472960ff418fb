"""Topics by expression."""

import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.ros.topics.choice import Awaited, pattern


def test_awaited_topics_need_as_many_subscribers_as_they_say():
    assert Awaited.parsed('/a.*').subscribers is None
    assert Awaited.parsed('/a.* 2').subscribers == 2
    with pytest.raises(ConfigError, match='a number after the blank'):
        Awaited.parsed('/a many')


def test_what_is_no_expression_is_refused():
    with pytest.raises(ConfigError, match='is not a regular expression'):
        pattern('(')
