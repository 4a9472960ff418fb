import pytest

from mctrack_ros.ground import SceneError, read_scene, write_scene

POINTS = {'a': (0.0, 1.5), 'b "&<': (-2.25, 1e-3), 'c': (1 / 3, 68.0)}


def test_a_scene_survives_its_file_and_is_written_back_identically(tmp_path):
    write_scene(POINTS, tmp_path / 'one.xml')
    back = read_scene(tmp_path / 'one.xml')
    assert back == POINTS
    assert list(back) == list(POINTS)
    write_scene(back, tmp_path / 'two.xml')
    assert (tmp_path / 'one.xml').read_bytes() == (tmp_path / 'two.xml').read_bytes()


@pytest.mark.parametrize(
    ('text', 'reason'),
    [
        ('no XML', 'not a readable XML file'),
        ('<workstation/>', r':1: the root is <workstation>, expected <scene>'),
        ('<scene/>', r':1: .*Missing child'),
        ('<scene>\n<point name="a" x="1"/></scene>', r":2: .*'y' is required but missing"),
        ('<scene>\n\n<point name="a" x="NaN" y="1"/></scene>', r":3: .*'NaN'"),
        (
            '<scene>\n<point name="a" x="east" y="1"/></scene>',
            r":2: .*'east', expected a number such as",
        ),
        ('<scene><point name="" x="1" y="1"/></scene>', 'minLength'),
        (
            '<scene><point name="a" x="1" y="1"/>\n<point name="a" x="2" y="1"/></scene>',
            r":2: point 'a' is there twice",
        ),
        (
            '<scene><point name="a" x="1" y="1"/>\n<point name="b" x="1" y="1"/></scene>',
            r":2: point 'b' lies where point 'a' does",
        ),
        (
            '<!DOCTYPE s [<!ENTITY e SYSTEM "file:///etc/passwd">]><scene>&e;</scene>',
            'document types and entities are refused',
        ),
        (
            '<!DOCTYPE s [<!ENTITY a "aaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]>'
            '<scene><point name="&b;" x="1" y="1"/></scene>',
            'document types and entities are refused',
        ),
    ],
)
def test_scenes_that_cannot_be_used_are_refused_by_file_line_and_reason(tmp_path, text, reason):
    path = tmp_path / 'scene.xml'
    path.write_text(text)
    with pytest.raises(SceneError, match=reason) as refusal:
        read_scene(path)
    assert str(path) in str(refusal.value)
    assert '\n' not in str(refusal.value)


def test_a_missing_scene_is_named(tmp_path):
    with pytest.raises(SceneError, match=r'scene.xml: No such file'):
        read_scene(tmp_path / 'scene.xml')


def test_notes_between_points_are_passed_over(tmp_path):
    path = tmp_path / 'scene.xml'
    path.write_text('<scene><!-- tiles --><point name="a" x="1" y="2"/><?x y?></scene>')
    assert read_scene(path) == {'a': (1.0, 2.0)}
