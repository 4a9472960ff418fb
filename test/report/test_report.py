import re

import cv2
import numpy as np
import pytest

from mctrack_ros.evaluation import ground_timeline
from mctrack_ros.evaluation.figures import Figures
from mctrack_ros.ground import ProjectiveMapping
from mctrack_ros.interfaces import EventCode, Events, Tracks
from mctrack_ros.recording import BagError, BagWriter, read_mot_text
from mctrack_ros.report import drops_of, load_session, write_birdseye
from mctrack_ros.report.demo import DemoOptions, evaluate_demo
from mctrack_ros.report.images import camera_images
from mctrack_ros.report.strips import encounter_strips, encounters
from well_formed import Balanced


@pytest.fixture(scope='module')
def results(match):
    """The figures of the small match; its folder holds the files."""
    return evaluate_demo(DemoOptions(seconds=4.0, cameras=2, out=match.folder))


def test_truth_and_tracks_share_their_time_though_the_recording_is_restamped(match):
    session = load_session(match.source, match.recorded)
    assert session.offset_ns == match.offset_ns
    assert session.period_ns == match.period_ns
    assert session.cameras == ('cam1', 'cam2')
    truth, tracks = session.trajectories()
    assert truth.frame.max() == tracks.frame.max() == match.instants - 1
    np.testing.assert_allclose(session.latency_ms(), 20.0)


def test_figures_of_the_match(match, results):
    figures = results.figures
    lost = 10
    assert figures['switches'] == 2
    assert figures['misses'] == lost
    assert figures['false_positives'] == 0
    assert figures['mota'] == pytest.approx(1 - (lost + 2) / (match.people * match.instants))
    assert figures['position_error_m'] == pytest.approx(0.5, abs=1e-5)
    assert figures['latency_p50_ms'] == pytest.approx(20.0)
    assert figures['latency_p99_ms'] == pytest.approx(20.0)
    assert figures['realtime_factor'] == pytest.approx(1.0)
    assert (figures['ticks'], figures['ticks_expected']) == (100, 100)


def test_what_is_late_in_the_first_seconds_is_counted_apart(results):
    figures = results.figures
    assert (figures['late_ticks'], figures['late_ticks_at_start']) == (1, 1)
    assert (figures['dropped_detections'], figures['dropped_detections_at_start']) == (2, 2)


def test_summary_is_read_back(match, results):
    assert Figures.read(match.folder / 'summary.json') == results
    names = {'mota', 'idf1', 'hota', 'moda', 'position_error_m', 'latency_p50_ms'}
    names |= {'latency_p99_ms', 'realtime_factor', 'ticks', 'late_ticks', 'dropped_detections'}
    assert names <= results.figures.keys()


def test_report_is_one_well_formed_page_that_needs_no_network(match, results):
    text = (match.folder / 'report.html').read_text()
    page = Balanced()
    page.feed(text)
    assert page.open == []
    assert page.images == 2
    assert all(a.startswith(('data:image/jpeg;base64,', '#')) for a in page.addresses)
    assert not re.search(r'https?:|//[a-z]|@import|url\((?!#)', re.sub(r'base64,[^"]*', '', text))


def test_text_from_outside_is_escaped(match, results):
    text = (match.folder / 'report.html').read_text()
    assert '<script>alert(1)' not in text
    assert '&lt;script&gt;alert(1)&lt;/script&gt;' in text


def test_report_names_what_missed_its_target(match, results):
    text = (match.folder / 'report.html').read_text()
    assert 'late ticks after 2 s' in text
    assert '✗ target ≤ 0' in text
    assert '✓ target ≥ 0.85' in text


def test_report_lists_the_switches_and_how_to_ask_why(match, results):
    text = (match.folder / 'report.html').read_text()
    assert '2.40 s  1 was 11 (until 2.36 s), is 12' in text
    assert f'mctrack explain {match.recorded} --track 12 --at 2.40' in text


def test_video_has_an_image_for_every_other_instant(match, results):
    video = cv2.VideoCapture(str(match.folder / 'birdseye.webm'))
    images = []
    while True:
        there, image = video.read()
        if not there:
            break
        images.append(image)
    assert len(images) == match.instants // 2
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(12.5)
    assert np.abs(images[0].astype(int) - images[-1]).max() > 50


def test_video_lightens_what_cameras_see(match, tmp_path):
    session = load_session(match.source, match.recorded)
    west = ProjectiveMapping.from_homography(
        np.array([[10.0, 0, 0], [0, 10.0, 0], [0, 0, 1.0]]), (500, 680)
    )
    write_birdseye(tmp_path / 'a.webm', session, [west])
    there, image = cv2.VideoCapture(str(tmp_path / 'a.webm')).read()
    assert there
    middle = image[image.shape[0] // 2].mean(axis=1)
    assert np.median(middle[20:200]) > np.median(middle[-200:-20]) + 5


def test_video_that_cannot_be_written_is_named(match, tmp_path):
    session = load_session(match.source, match.recorded)
    with pytest.raises(OSError, match=r'b\.webm cannot be written'):
        write_birdseye(tmp_path / 'absent' / 'b.webm', session)


def test_text_holds_the_tracks_and_the_truth(match, results):
    tracks = read_mot_text(match.folder / 'tracks.txt', match.period_ns)
    truth = read_mot_text(match.folder / 'truth.txt', match.period_ns)
    assert [len(rows) for rows in truth] == [4] * 100
    assert [len(rows) for rows in tracks] == [4] * 90 + [3] * 10
    assert [rows.stamp_ns for rows in tracks] == [rows.stamp_ns for rows in truth]


def test_timeline_shows_the_switch_and_the_loss(match):
    line = ground_timeline(*load_session(match.source, match.recorded).trajectories(), 1.0)
    assert line.switch_frame.tolist() == [60, 60]
    assert line.tracks.tolist() == [4] * 90 + [3] * 10


def test_drops_are_counted_by_camera(match):
    session = load_session(match.source, match.recorded)
    drops = drops_of(session.ticks, session.start_ns, 2)
    assert drops.per_camera('late').tolist() == [0, 2]
    assert drops.per_camera('admitted').tolist() == [100, 98]
    assert drops.total('late', start_s=2.0) == 1


def test_images_show_the_boxes(match):
    session = load_session(match.source, match.recorded)
    images = camera_images(session, session.truth[50].stamp_ns)
    assert [image.camera for image in images] == ['cam1', 'cam2']
    assert images[0].caption == '2 detections, 1 with a global id'


def test_an_encounter_is_a_merge_of_two_and_their_next_split():
    told = [
        (1, EventCode.MERGE, 4, [7]),
        (2, EventCode.MERGE, 4, [8, 9]),
        (3, EventCode.SPLIT, 4, [9]),
        (4, EventCode.SPLIT, 7, [4]),
        (5, EventCode.SPLIT, 7, [4]),
    ]
    events = [
        Events.build(
            stamp, event=[code], local_id=[local], others=[others + [0] * (16 - len(others))]
        )
        for stamp, code, local, others in told
    ]
    found = list(encounters('cam1', events))
    assert [(one.pair, one.merged_ns, one.split_ns) for one in found] == [((4, 7), 1, 4)]


def test_a_match_without_encounters_has_no_strips(match):
    assert encounter_strips(load_session(match.source, match.recorded)) == []


def test_recording_of_another_match_is_refused(match, tmp_path):
    with BagWriter(tmp_path / 'other') as bag:
        rows = Tracks.build(10**9, position=[[1, 2, 0]], track_id=[1])
        for topic in ('/truth/tracks', '/tracks'):
            bag.write_rows(topic, rows, 'map')
    with pytest.raises(BagError, match='holds another truth'):
        load_session(match.source, tmp_path / 'other')


def test_offline_there_is_no_latency_and_the_pace_is_that_of_the_run(match, tmp_path):
    options = DemoOptions(seconds=4.0, cameras=2, offline=True, out=tmp_path)
    (tmp_path / 'source').symlink_to(match.source)
    (tmp_path / 'bag').symlink_to(match.recorded)
    figures = evaluate_demo(options, wall_seconds=2.0).figures
    assert np.isnan(figures['latency_p50_ms'])
    assert figures['realtime_factor'] == pytest.approx(2.0)


def test_command_names_what_is_not_usual():
    assert DemoOptions().command == 'mctrack demo --seconds 120'
    options = DemoOptions(seconds=10, cameras=3, offline=True, seed=7)
    assert options.command == 'mctrack demo --seconds 10 --cameras 3 --seed 7 --offline'
