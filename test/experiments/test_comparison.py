import pytest

from mctrack_ros.experiments.comparison import compare
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagError, BagReader, MotTextError, write_mot_text


def texts(match, folder):
    """Write the recording's tracks and truth as text."""
    with BagReader(match.recorded) as reader:
        for topic, name in (('/tracks', 'tracks.txt'), ('/truth/tracks', 'truth.txt')):
            instants = [rows for rows, _ in reader.rows(topic, Tracks)]
            origin_ns = match.offset_ns + match.period_ns
            write_mot_text(folder / name, instants, match.period_ns, origin_ns)
    lines = (folder / 'tracks.txt').read_text().splitlines(keepends=True)
    kept = [line for line in lines if not line.startswith('0,')]
    (folder / 'tracks.txt').write_text(''.join(kept))
    return folder / 'truth.txt', folder / 'tracks.txt'


def test_bag_and_text_of_the_same_score_the_same(match, tmp_path):
    truth, tracks = texts(match, tmp_path)
    of_text = compare(truth, tracks).figures
    assert of_text['mota'] == pytest.approx(1 - 12 / (4 * 99))
    assert compare(match.recorded, tracks).figures == pytest.approx(of_text, abs=1e-4)
    of_bag = compare(match.recorded, match.recorded).figures
    extra = match.people
    assert of_bag['false_positives'] == of_text['false_positives'] + extra
    assert of_bag['misses'] == of_text['misses']


def test_gate_is_in_the_protocol_and_changes_the_figures(match):
    narrow = compare(match.recorded, match.recorded, gate_m=0.4)
    assert narrow.protocol['gate_m'] == 0.4
    assert narrow.figures['recall'] == 0.0


def test_recordings_without_a_common_instant_are_refused(match):
    with pytest.raises(ValueError, match='have no instant in common'):
        compare(match.source, match.recorded)


def test_missing_files_and_topics_are_named(match, tmp_path):
    with pytest.raises(BagError, match='absent does not exist'):
        compare(tmp_path / 'absent', match.recorded)
    with pytest.raises(BagError, match='has no topic /tracks'):
        compare(match.source, match.source)
    (tmp_path / 'bad.txt').write_text('1,2\n')
    with pytest.raises(MotTextError, match=r'bad\.txt, line 1'):
        compare(match.recorded, tmp_path / 'bad.txt')
