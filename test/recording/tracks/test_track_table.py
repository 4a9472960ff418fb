from mctrack_ros.interfaces import ClassCode, Tracks, TrackStatus
from mctrack_ros.recording import TrackTableWriter

PERIOD_NS = 40_000_000


def test_the_table_says_what_mot_text_cannot(tmp_path):
    path = tmp_path / 'deep' / 'tracks.csv'
    with TrackTableWriter(path, PERIOD_NS, origin=(100.0, 0.0)) as table:
        table.write(Tracks.build(0))
        table.write(
            Tracks.build(
                PERIOD_NS + 1,
                track_id=[3, 4],
                position=[[1.5, -2.25, 0], [0, 0, 0]],
                velocity=[[1, 0.5], [0, 0]],
                class_id=[ClassCode.PERSON, ClassCode.PERSON],
                status=[TrackStatus.COASTING, TrackStatus.TENTATIVE],
                score=[0.5, 1],
                group=[7, 0],
            )
        )
    assert path.read_text() == (
        'time,frame,track_id,x,y,vx,vy,class,status,score,group\n'
        '0.040000001,2,3,101.5000,-2.2500,1.000,0.500,person,coasting,0.500,7\n'
    )
