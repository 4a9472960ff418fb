import pytest

from mctrack_ros.evaluation.comparison import Comparison, compare
from mctrack_ros.interfaces import Tracks
from mctrack_ros.recording import BagError, BagReader, BagWriter, MotTextError, write_mot_text


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


def tracks_every(period_ns, path, offset_ns):
    """Write tracks of one target at another rate, from the first instant of the truth on."""
    with BagWriter(path) as bag:
        for stamp in range(offset_ns + 60_000_000, offset_ns + 4_000_000_000, period_ns):
            bag.write_rows(
                '/tracks', Tracks.build(stamp, position=[[1, 2, 0]], track_id=[1]), 'map'
            )
    return path


def test_tracks_at_another_rate_than_truth_are_told_of(match, tmp_path):
    slow = tracks_every(80_000_000, tmp_path / 'slow', match.offset_ns)
    note = Comparison.read(match.recorded, slow).note
    assert 'truth comes every 40 ms, tracks every 80 ms' in note
    assert not Comparison.read(match.recorded, match.recorded).note
    fast = tracks_every(20_000_000, tmp_path / 'fast', match.offset_ns)
    with pytest.raises(ValueError, match=r'fast: .*tracks every 20 ms'):
        compare(match.recorded, fast)


def test_the_folder_that_track_wrote_stands_for_its_bag(match):
    of_folder = Comparison.read(match.recorded, match.folder)
    assert of_folder.tracks_path == match.recorded
    assert of_folder.figures(1.0).figures == compare(match.recorded, match.recorded).figures


def test_frames_are_called_by_what_they_count(match):
    result = compare(match.recorded, match.recorded)
    assert result.protocol['frames with truth'] == 99
    assert result.figures['frames'] == 100
    assert 'frames' not in result.protocol


def test_missing_files_and_topics_are_named(match, tmp_path):
    with pytest.raises(BagError, match='absent does not exist'):
        compare(tmp_path / 'absent', match.recorded)
    with pytest.raises(BagError, match='has no topic /tracks'):
        compare(match.source, match.source)
    (tmp_path / 'bad.txt').write_text('1,2\n')
    with pytest.raises(MotTextError, match=r'bad\.txt, line 1'):
        compare(match.recorded, tmp_path / 'bad.txt')
