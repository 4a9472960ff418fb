"""Names that ROS allows, and no others."""

import pytest

from mctrack_ros.config import ConfigError
from mctrack_ros.site.names import check_camera_name, named_image_topic, namespace_of, resolved


@pytest.mark.parametrize('name', ['cam1', 'D455_1', 'NORTH', '_hidden', 'c'])
def test_names_that_ros_allows_are_taken(name):
    check_camera_name(name)


@pytest.mark.parametrize('name', ['', '1cam', 'a__b', 'a b', 'a/b', 'a-b', 'caméra', 3, 'cam1\n'])
def test_others_are_refused_by_name(name):
    with pytest.raises(ConfigError, match='expected letters, digits and single underscores'):
        check_camera_name(name)


@pytest.mark.parametrize(
    ('text', 'namespace'),
    [('', ''), ('/', ''), ('hall', '/hall'), ('/hall/', '/hall'), ('a/B_2', '/a/B_2')],
)
def test_a_namespace_begins_with_one_slash_however_it_is_written(text, namespace):
    assert namespace_of(text) == namespace


@pytest.mark.parametrize('text', ['1hall', 'a//b', 'a b', '/a-b'])
def test_what_is_no_namespace_is_refused(text):
    with pytest.raises(ConfigError, match='namespace'):
        namespace_of(text)


def test_images_lie_below_the_camera_unless_their_name_is_whole():
    assert resolved(named_image_topic('cam1', 'image_raw'), '/hall') == '/hall/cam1/image_raw'
    assert resolved(named_image_topic('cam1', '/D455_1/color'), '/hall') == '/D455_1/color'
