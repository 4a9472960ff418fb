import pytest

from mctrack_ros.recording.video.image_times import ImageTimes


def times_of(stated, constant=False):
    times = ImageTimes(0.04, constant=constant)
    return [times.time_of(each) for each in stated], times.notes()


def test_rising_times_are_taken_as_they_are():
    assert times_of([0.5, 0.54, 0.7]) == ([0.5, 0.54, 0.7], [])


def test_a_missing_time_is_one_period_after_the_last():
    found, notes = times_of([0.0, None, None, 0.12])
    assert found == pytest.approx([0.0, 0.04, 0.08, 0.12])
    assert notes == ['2 images without a time, put one period after the image before']


def test_an_image_that_is_no_later_is_left_out():
    found, notes = times_of([0.0, 0.04, 0.04, 0.02, 0.08])
    assert found == [0.0, 0.04, None, None, 0.08]
    assert notes == ['2 images left out: their times are not later than those before']


def test_times_that_begin_anew_go_on_after_the_last():
    found, notes = times_of([5.0, 5.04, 0.0, 0.04, 0.0], constant=False)
    assert found[:4] == pytest.approx([5.0, 5.04, 5.08, 5.12])
    assert found[4] is None
    assert 'step back' in notes[1]
    assert 'from 5.040 to 0.000 s' in notes[1]


def test_a_gap_is_kept_and_told():
    found, notes = times_of([0.0, 0.04, 37600.0, 37600.04])
    assert found == [0.0, 0.04, 37600.0, 37600.04]
    assert 'from 0.040 to 37600.000 s' in notes[0]


def test_a_constant_rate_counts_what_cannot_be_decoded():
    times = ImageTimes(0.1, constant=True)
    assert times.time_of(7.0) == 0.0
    times.pass_over(2)
    assert times.time_of(7.1) == pytest.approx(0.3)
