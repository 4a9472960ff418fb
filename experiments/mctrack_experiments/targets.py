"""What the figures should reach, and what others reach."""

from __future__ import annotations

from mctrack_ros.report.targets import DEMO_TARGETS, Target

_GLUE = 'OpenCV and norfair'
_CLUSTERS = 'MOG2, clusters and norfair'

TARGETS = (
    Target('terrace4', 'terrace4.gate_half_metre.moda', 'terrace, four cameras, MODA at 0.5 m',
           0.94, None,
           f'{_CLUSTERS}: .593; on the second half of the sequence: '
           'POM-CNN .58, UMPD, without labels, .738, MVDet .872, 3DROM .948'),
    Target('terrace4', 'terrace4.gate_half_metre.modp', 'the same, MODP', 0.62, None,
           'on the second half: POM-CNN .46, UMPD .590, MVDet .700, 3DROM .705'),
    Target('terrace4', 'terrace4.moda', 'terrace, four cameras, MODA at 1 m', 0.95, None,
           f'{_CLUSTERS}: .703'),
    Target('terrace4', 'terrace4.mota', 'terrace, four cameras, MOTA at 1 m', 0.95, None,
           f'{_CLUSTERS}: .650'),
    Target('terrace4', 'terrace4.idf1', 'terrace, four cameras, IDF1', 0.93, None,
           f'{_CLUSTERS}: .293'),
    Target('terrace4', 'terrace4.switches', 'terrace, four cameras, switches', None, 10),
    *(
        Target('terrace4', f'terrace4.{part}.{figure}', f'terrace, {frames}, {label}', least, None,
               f'five runs: `terrace4.{part}.{figure}.least` to '
               f'`terrace4.{part}.{figure}.most`')
        for part, frames in (('to_1250', 'to frame 1250'), ('from_1251', 'from frame 1251'))
        for figure, label, least in (
            ('gate_half_metre.moda', 'MODA at 0.5 m', 0.94),
            ('gate_half_metre.modp', 'MODP at 0.5 m', 0.62),
            ('mota', 'MOTA at 1 m', 0.95),
            ('idf1', 'IDF1 at 1 m', 0.93),
        )
    ),
    Target('terrace4', 'terrace4.foreground.left',
           'terrace, foreground at places left 20 s ago or earlier, share', None, 0.0075,
           'where nobody has been: `terrace4.foreground.never`'),
    Target('terrace4', 'terrace4.foreground.mask_bytes',
           'terrace, mask of a camera, 90 x 72 px, mean size, bytes', None, 500),
    Target('terrace4', 'terrace4.joint.mota', 'terrace, four cameras, joint tracker, MOTA', 0.767),
    Target('terrace4', 'terrace4.joint.idf1', 'the same, IDF1', 0.722),
    Target('moving_camera', 'lines.end_worst_m',
           'cameras that pan, tilt and zoom, drift after a minute, the worst camera, m', None, 0.5,
           'features alone: `features.end_worst_m`'),
    Target('moving_camera', 'lines.p95_m', 'the same, 95 % of all places in all images, m', None,
           0.5, 'features alone: `features.p95_m`'),
    Target('moving_camera', 'lines.lost_images', 'the same, images in which it was lost', None, 0),
    *(
        target
        for prefix, words in (
            ('', 'static cameras'),
            ('ptz.', 'cameras that pan, tilt and zoom'),
            ('real.', 'real motion'),
        )
        for target in (
            Target('belief', f'{prefix}belief.kept',
                   f'belief propagation, occlusions in one view kept, {words}', 0.95, None,
                   f'centralised fusion `{prefix}central.kept`, best view '
                   f'`{prefix}best_view.kept`, Condensation `{prefix}condensation.kept`'),
            Target('belief', f'{prefix}lead.central.low',
                   'the same, ahead of centralised fusion, lower end of the 95 % interval', 0.0,
                   None, f'of best view: `{prefix}lead.best_view.low`'),
        )
    ),
    Target('belief', 'default.kept', 'the joint tracker on the same images, static cameras',
           None, None, 'belief propagation ahead of it by `lead.default`'),
    Target('belief', 'entropy.lead.low',
           'entropy of messages from the occluded view over that from the clear one, lower end',
           0.0, None, '`entropy.occluded` and `entropy.clear`; at most log 200 = 5.298'),
    Target('belief', 'belief.crossings.kept',
           "terrace, two videos, first half, crossings that belief propagation keeps", None, None,
           'default tracker `default.crossings.kept`, of `crossings`'),
    Target('grid', 'indoor.both.median_m', 'indoor scene, masks and edges, median error, m', None,
           0.10, 'the paper: mostly below 0.10 to 0.15; edges alone: `indoor.paper.median_m`'),
    Target('grid', 'indoor.both.lost_identities', 'the same, lost identities a target', None, 1,
           'the paper: 4 to 5; edges alone: `indoor.paper.lost_identities`'),
    Target('grid', 'indoor.both.mota', 'the same, MOTA at 0.5 m', 0.95, None,
           'edges alone: `indoor.paper.mota`; occupancy: `indoor.occupancy.mota`'),
    Target('grid', 'indoor.both.idf1', 'the same, IDF1', None, None,
           'edges alone: `indoor.paper.idf1`; occupancy: `indoor.occupancy.idf1`'),
    Target('grid', 'step.lost_tracks', 'the same, tracks that a light step of 30 % costs',
           None, 0),
    Target('grid', 'speed.edge_maps', 'four-camera sets a second, one core, from edge maps', 50,
           None, 'the paper: 2'),
    Target('grid', 'speed.images', 'the same from images of 752 x 480 px, edges alone', 30,
           None),
    Target('grid', 'speed.images_both', 'the same, masks and edges', 30),
    *(
        Target('grid', f'cameras_{count}.mota', f'indoor scene, {count} cameras, MOTA at 0.5 m',
               None, None, f'IDF1 `cameras_{count}.idf1`')
        for count in (2, 3, 6, 8)
    ),
    *(
        Target('grid', f'indoor.both_{shape}.mota', f'indoor scene, outline {shape}, MOTA',
               None, None, f'edges alone `indoor.edges_{shape}.mota`, with the cylinder '
               '`indoor.edges.mota`')
        for shape in ('person', 'ellipsoid')
    ),
    Target('grid', 'terrace.both.to_1250.gate_half_metre.moda',
           'terrace, likelihood grid, to frame 1250, MODA at 0.5 m', 0.94, None,
           'edges alone: `terrace.edges.to_1250.gate_half_metre.moda`; '
           'occupancy: `terrace.occupancy.to_1250.gate_half_metre.moda`'),
    Target('grid', 'terrace.both.from_1251.gate_half_metre.moda',
           'the same from frame 1251', 0.92, None,
           'edges alone: `terrace.edges.from_1251.gate_half_metre.moda`; '
           'occupancy: `terrace.occupancy.from_1251.gate_half_metre.moda`'),
    Target('grid', 'terrace.both.from_1251.mota', 'the same, MOTA at 1 m', 0.95, None,
           'occupancy: `terrace.occupancy.from_1251.mota`'),
    Target('grid', 'terrace.both.from_1251.idf1', 'the same, IDF1', 0.93, None,
           'occupancy: `terrace.occupancy.from_1251.idf1`'),
    Target('terrace', 'terrace.mota', 'terrace, two videos, MOTA at 1 m', 0.80, None,
           f'{_CLUSTERS}: .516'),
    Target('terrace', 'terrace.idf1', 'terrace, two videos, IDF1', 0.75, None,
           f'{_CLUSTERS}: .253'),
    *(
        target
        for scene, label in (
            ('furniture', 'somebody carries a chair in'),
            ('door', 'a sliding door'),
            ('bump', 'a camera is bumped'),
            ('exposure', 'exposure drifts'),
            ('night', 'the lights go out'),
            ('start', 'people from the first image on'),
            ('jitter', 'a camera shakes'),
            ('standing', 'somebody stands for three minutes'),
        )
        for target in (
            Target('views', f'{scene}.most_false', f'{label}, most false tracks', None, 1),
            Target('views', f'{scene}.false_s', 'the same, false tracks last, s', None, 2),
            Target('views', f'{scene}.longest_miss_s',
                   'the same, longest time that a person has no track, s', None, 0),
        )
    ),
    Target('street', 'street.mota', 'street, one low camera, MOTA at 1 m', 0.45),
    Target('street', 'street.idf1', 'street, one low camera, IDF1', 0.50),
    *(
        Target('foreground', f'ours.{name}.f', f'foreground, {name}, F', least, None,
               f'OpenCV with defaults: MOG2 `mog2.{name}.f`, KNN `knn.{name}.f`, '
               f'GSOC `gsoc.{name}.f`; bgslibrary: SuBSENSE `subsense.{name}.f`')
        for name, least in (('highway', 0.95), ('office', 0.95), ('corridor', 0.85))
    ),
    Target('foreground', 'ours.images_a_second', 'the same, images a second, 320 x 240 px', 1000,
           None, 'MOG2 `mog2.images_a_second`, KNN `knn.images_a_second`, GSOC '
           '`gsoc.images_a_second`'),
    Target('terrace_live', 'terrace.agreement_median_m', 'terrace live, views apart, median, m',
           most=0.5),
    Target('terrace_live', 'terrace.isolated_breaks', 'terrace live, ids lost while isolated',
           most=0),
    Target('pets', 'pets.pixels.moda', 'PETS, one camera from pixels, MODA', 0.88, None,
           f'tuned on frames 1-397: `pets.pixels.tuned.moda`; {_GLUE}: .817'),
    Target('pets', 'pets.pixels.mota', 'PETS, one camera from pixels, MOTA', 0.87, None,
           f'tuned on frames 1-397: `pets.pixels.tuned.mota`; {_GLUE}: .810; '
           'published trackers: .77 to .83'),
    Target('pets', 'pets.pixels.idf1', 'PETS, one camera from pixels, IDF1', 0.80, None,
           f'tuned on frames 1-397: `pets.pixels.tuned.idf1`; {_GLUE}: .652; '
           'published trackers: .67 to .80'),
    Target('pets', 'pets.pixels.switches', 'PETS, one camera from pixels, switches', None, None,
           f'{_GLUE}: 16'),
    Target('pets', 'pets.multiview.moda', 'PETS, six views, MODA', 0.88, None,
           'MOTA of classical multi-view work: said to be .80 to .98'),
    Target('pets', 'pets.multiview.mota', 'PETS, six views, MOTA', 0.92),
    Target('pets', 'pets.multiview.idf1', 'PETS, six views, IDF1', 0.90),
    Target('wildtrack', 'wildtrack.mota', 'WILDTRACK, training split, MOTA', None, None,
           'model-based trackers, test split: .70 to .75'),
    Target('wildtrack', 'wildtrack.idf1', 'WILDTRACK, training split, IDF1', None, None,
           'model-based trackers, test split: .73 to .82'),
    Target('wildtrack', 'wildtrack.perfect.mota', 'WILDTRACK, annotated boxes, MOTA', 0.95),
    Target('wildtrack', 'wildtrack.perfect.idf1', 'WILDTRACK, annotated boxes, IDF1', 0.90),
    Target('lab6p', 'lab6p.moda', 'lab6p, four cameras, MODA at 0.5 m', 0.95, None,
           'clustering and norfair: MOTA .947; clustering alone: MODA .93'),
    Target('lab6p', 'lab6p.mota', 'lab6p, four cameras, MOTA at 0.5 m', 0.97, None,
           'clustering and norfair: .943'),
    Target('lab6p', 'lab6p.idf1', 'lab6p, four cameras, IDF1', 0.96, None,
           'clustering and norfair: .891'),
    Target('lab6p', 'lab6p.switches', 'lab6p, four cameras, switches', None, 0,
           'clustering and norfair: 2'),
    Target('lab6p', 'lab6p.best_single.moda', 'lab6p, best single camera, MODA', None, None,
           'clustering: .88'),
    Target('cmc', 'cmc1.mota', 'CMC1, MOTA at 1 m', 0.995, None,
           'clustering and norfair: .880; MS-GLMB: 1.000'),
    Target('cmc', 'cmc1.idf1', 'CMC1, IDF1', 0.995, None, 'MS-GLMB: 1.000'),
    Target('cmc', 'cmc1.switches', 'CMC1, switches', None, 0),
    Target('cmc', 'cmc2.mota', 'CMC2, MOTA at 1 m', 0.985, None,
           'clustering and norfair: .754; MS-GLMB: .985'),
    Target('cmc', 'cmc2.idf1', 'CMC2, IDF1', 0.993, None,
           'clustering and norfair: .34; MS-GLMB: .993'),
    Target('cmc', 'cmc2.gate_half_metre.mota', 'CMC2, MOTA at 0.5 m', 0.94, None,
           'MS-GLMB: .940'),
    Target('cmc', 'cmc2.gate_half_metre.idf1', 'CMC2, IDF1 at 0.5 m', 0.967, None,
           'MS-GLMB: .967'),
    Target('intel', 'default.wrong', 'Intel clips, objects too many or too few', None, 0,
           'tuned on these clips: `tuned.wrong`'),
    Target('cameras', 'pets.view1.median_m', 'PETS view 1, Tsai, median error, m', most=0.05),
    Target(
        'cameras', 'pets.clicked12.median_m', 'camera fitted to 12 clicks, median, m', most=0.15
    ),
    Target('cameras', 'pets.clicked12.worst_seed_m', 'the same, worst of 20 seeds, m', most=0.15),
    Target('cameras', 'wildtrack.worst_median_m', 'WILDTRACK, worst of 7 medians, m', most=0.12),
    Target('cameras', 'lab6p.largest_m', 'lab6p, largest difference, m', most=1e-6),
    Target('camera_shift', 'false_alarms', 'moved camera, false alarms in all', most=0),
    Target('camera_shift', '2px.delay_max_s', 'camera moved by 2 px, longest delay, s', most=5),
    Target('camera_shift', '5px.delay_max_s', 'camera moved by 5 px, longest delay, s', most=5),
    Target('camera_shift', '20px.delay_max_s', 'camera moved by 20 px, longest delay, s', most=5),
    Target('camera_shift', 'turn.delay_max_s', 'camera turned by 1 degree, longest delay, s',
           most=5),
    *DEMO_TARGETS,
    Target('track', 'realtime_factor', 'offline, times real time', least=3.0),
    Target('table3', 'fitted.rmse_max_m', 'Experiment I, fitted camera, worst RMSE, m', None, 0.06,
           "the paper's method, its own pose: 0.28 to 1.02"),
    Target('table3', 'fitted.crb_ratio_max', 'the same over the Cramer-Rao bound, paths pooled',
           None, 1.2,
           'the worst single path, not pooled: `fitted.crb_ratio_of_a_path_max`'),
    Target('table3', 'cell.rmse_max_m', 'Experiment I, projective cells, worst RMSE, m'),
    Target('table3', 'iterated.rmse_max_m', "Experiment I, the paper's method, worst RMSE, m",
           None, None, 'the paper, its own pose: 1.02'),
    Target('table3', 'homography.rmse_max_m', 'Experiment I, one homography, worst RMSE, m'),
    Target('table3', 'plane1.rmse_max_m', 'Experiment I, plane 1 of [17], worst RMSE, m',
           None, None, 'the paper, its own pose: 35.2'),
    Target('table3', 'plane2.rmse_max_m', 'Experiment I, plane 2 of [17], worst RMSE, m',
           None, None, 'the paper, its own pose: 15.5'),
    Target('honesty', 'nees.mean', 'predicted errors of 200 fitted cameras: NEES', None, 2.163,
           'an honest prediction: 1.843 to 2.163'),
    Target('honesty', 'nees.coverage', 'cameras whose error is within the predicted 95 %', 0.92),
    Target('honesty', 'edge.mean_max', 'NEES, the worst of nine lenses at the edges, 200 cameras',
           None, 2.163, 'principal point 20 px off, k2 0.05, aspect 1 %'),
    Target('bench_ground', 'fitted.points_per_s', 'fitted camera with covariance, points/s', 1e6),
    Target('bench_ground', 'cell.points_per_s', 'projective cells with covariance, points/s', 1e6),
    Target('bench_ground', 'iterated.points_per_s', "the paper's grid, points/s", 2e5,
           None, 'the paper: more than 1000'),
    Target('table4', 'e1.f1', 'pitch, five matches: new, background given, F1', least=0.90),
    Target('table4', 'e2.f1', 'entered, F1', least=0.90),
    Target('table4', 'e3.f1', 'split, F1', least=0.85),
    Target('table4', 'e4.f1', 'left, F1', least=0.90),
    Target('table4', 'e5.f1', 'merged, F1', least=0.90),
    Target('table4', 'e1.ratio', 'new, told over true', 0.88, None, 'the paper: .88'),
    Target('table4', 'e2.ratio', 'entered, told over true', 0.97, None, 'the paper: .97'),
    Target('table4', 'e3.ratio', 'split, told over true', 0.79, None, 'the paper: .79'),
    Target('table4', 'e4.ratio', 'left, told over true', 1.0, None, 'the paper: 1.00'),
    Target('table4', 'e5.ratio', 'merged, told over true', 0.94, None, 'the paper: .94'),
    *(
        Target('table4', f'e{number}.precision', f'{word}, share that is true', least=0.90)
        for number, word in enumerate(('new', 'entered', 'split', 'left', 'merged'), 1)
    ),
    Target('table4', 'learned.e1.within_500ms.f1', 'new, background learned live, F1 within 0.5 s',
           None, None, 'first pass: `first_pass.e1.within_500ms.f1`; live none at first'),
    Target('table4', 'learned.e1.within_2000ms.f1', 'the same, F1 within 2 s', None, None,
           'first pass: `first_pass.e1.within_2000ms.f1`; given: `given.e1.within_2000ms.f1`'),
    Target('table4', 'learned.e1.delay_median_s', 'the same, told after, s', None, None,
           'first pass: `first_pass.e1.delay_median_s`; given: `given.e1.delay_median_s`'),
    Target('table4', 'learned.mota', 'first 10 s, background learned live, MOTA', None, None,
           'first pass: `first_pass.mota`; given: `given.mota`'),
    Target('table4', 'correlation', 'true and estimated trajectories', None, None,
           'the paper, its own pitch: .81'),
    Target('table4', 'one_id_share', 'players who keep one id', least=0.85),
    Target('table4', 'mota', 'pitch, five matches of two minutes, MOTA', 0.95),
    Target('table4', 'idf1', 'the same, IDF1', 0.92),
    Target('table4', 'hota', 'the same, HOTA'),
    Target('table4', 'switches_a_minute', 'the same, switches a minute', most=5),
    Target('table4', 'switches_isolated', 'the same, switches while isolated', most=0),
    Target('table4', 'kits.purity', 'tracks of a kit that wear what most of it do'),
    Target('table4', 'kits.found', 'kits found of three, a match'),
    Target('fig14', 'whole_share', 'three who are one object at first: paths that are whole'),
    Target('fig14', 'whole_share.without_past', 'the same without the past of the group'),
    *(
        Target('fig16', f'{case}.{figure}', f'Figure 16, {case}: {label}')
        for case in ('grouping', 'splitting', 'entering', 'leaving')
        for figure, label in (('recall', 'events told'), ('one_id_share', 'one id kept'))
    ),
    Target('pairs', 'different.kept', 'ids through merge and split, different kits', least=0.95),
    Target('pairs', 'same.kept', 'ids through merge and split, the same kit', least=0.85),
    Target('silhouettes', 'events.correct', 'car park, events tracked perfectly', 0.90, None,
           "with the paper's own parameters: `printed.events.correct`; "
           'the paper, its own car park: 264 of 311, .849'),
    Target('silhouettes', 'pedestrians.passed', 'car park, pedestrians passed on', 0.97, None,
           "with the paper's own parameters: `printed.pedestrians.passed`; "
           'the paper, its own car park: 125 of 132, .947'),
    *(
        Target('classes', f'{kind}.right', f'car park, {kind} taken for what they are')
        for kind in ('people', 'bicycles', 'vehicles')
    ),
    Target('grey_carpark', 'people.mota', 'grey car park, people, MOTA at 1 m', 0.80),
    Target('grey_carpark', 'people.idf1', 'the same, IDF1'),
    Target('grey_carpark', 'vehicles.mota', 'the same, cars, MOTA at 2.5 m', 0.85),
    Target('grey_carpark', 'vehicles.idf1', 'the same, IDF1'),
    *(
        Target('hall', f'{kind}.{figure}', f'hall, {words}: {label}', None, None,
               f'joint tracker: `joint.{figure}`' if kind == 'shadows' else '')
        for kind, words in (('shadows', 'with shadows'), ('plain', 'without shadows'))
        for figure, label in (
            ('mota_0.5m', 'MOTA at 0.5 m'), ('idf1_0.5m', 'IDF1 at 0.5 m'),
            ('mota_1m', 'MOTA at 1 m'),
            ('feet.median_m', 'feet of the camera they fall towards, median error, m'),
            ('delay.median_s', 'from the door to a track, median, s'),
            ('delay.p95_s', 'the same, 95 %, s'),
            ('entering.tracks_per_person', 'tracks a person while groups come in'),
            ('left_over_s_per_min', 'false tracks left over, s a minute'),
        )
    ),
    *(
        Target('covering', f'{scene}.{tracker}.mota', f'{place}, {words}, MOTA')
        for scene, place in (
            ('pitch', 'pitch, one camera'), ('carpark', 'car park'),
            ('pets', 'PETS, one camera'), ('lab6p', 'lab6p, stored detections'),
        )
        for tracker, words in (
            ('covering_text', 'covering graph'), ('covering_code', "covering graph, code's cost"),
            ('kf_nn', 'Kalman filter and nearest neighbour'), ('ms_mt', 'mean shift'),
            ('pf_js', 'joint particle filter'), ('weighed_gnn', 'our default'), ('jpda', 'JPDA'),
        )
    ),
    Target('covering', 'beside.gain.covering_text', 'covering graph, second camera beside, MOTA '
           'gained', 0.083, None, 'the paper, its own sequence: .083'),
    Target('covering', 'facing.gain.covering_text', 'the same, second camera opposite', 0.083,
           None, 'the paper, its own sequence: .083'),
    Target('covering', 'assignment.facing.covering_text.cost_ratio', 'greedy over optimal, cost',
           None, None, 'the paper: "comparable to the Hungarian algorithm"'),
    Target('covering', 'assignment.facing.covering_text.association_share_of_tick',
           'covering graph with gate, costs and C, share of a tick with images', None, 0.05,
           'the paper: less than .05'),
    Target('covering', 'assignment.facing.covering_text.fusion_share_of_tick',
           'all of fusion, the same', None, None,
           'flags and exchange alone: `assignment.facing.covering_text.greedy_share_of_tick`'),
    Target('robustness', 'plain.mota', 'pitch undisturbed, MOTA'),
    Target('robustness', 'brighter.loss', 'light 30 % brighter at once, MOTA lost', most=0.05),
    Target('robustness', 'darker.loss', 'light 30 % darker at once, MOTA lost', most=0.05),
    Target('robustness', 'drift.loss', 'light drifts by 30 %, MOTA lost', most=0.05),
    Target('robustness', 'noise.loss', 'sensor noise doubled, MOTA lost', most=0.05),
    Target('robustness', 'shadows.loss', 'shadows, MOTA lost', most=0.05),
    *(
        Target('robustness', f'{name}.false', f'{words}, false detections an image', None, None,
               'undisturbed: `plain.false`')
        for name, words in (
            ('brighter', 'light 30 % brighter at once'), ('darker', 'light 30 % darker at once'),
            ('drift', 'light drifts by 30 %'), ('noise', 'sensor noise doubled'),
            ('shadows', 'shadows'), ('gain_up', 'gain up by 30 %'),
            ('gain_down', 'gain down by 30 %'),
        )
    ),
    Target('robustness', 'gain_up.recovery_max_s', 'gain up by 30 %, until recovered, s', most=1),
    Target('robustness', 'gain_down.recovery_max_s', 'gain down by 30 %, until recovered, s',
           most=1),
    Target('bench_camera_shift', 'ms_per_image', 'watching for a moved camera, ms an image',
           None, 0.3, 'phase correlation of each full image, in the same run'),
    Target('bench_start', 'first.s', 'first start of the default trackers, on two cores, s',
           most=30, anchor='a later start: `later.s`'),
    Target('bench_start', 'help.s', '`camera_node --help`, nothing compiled yet, s', most=2),
    Target('bench_camera', 'decoded.fps', 'camera, 25 people, from decoded images, a second',
           400, None, 'OpenCV MOG2 and contours in the same run: `peer.mog2_contours.fps`'),
    Target('bench_camera', 'jpeg.fps', 'camera, 25 people, from JPEG, a second', least=250),
    Target('bench_camera', 'crowded.fps', 'camera, 100 people, from decoded images, a second',
           least=150),
    Target('bench_camera', 'silhouettes.fps', 'silhouettes tracker, images a second', 400,
           None, 'OpenCV MOG2 and components in the same run: `peer.mog2_components.fps`'),
    Target('bench_belief', 'no_images.frames_per_second',
           'belief propagation, 10 targets, 2 views, 200 particles, no images, a second', 100),
    Target('bench_belief', 'images.frames_per_second', 'the same with images', 60),
    *(
        target
        for name, label in (('sqlite', 'SQLite'), ('postgres', 'PostgreSQL'))
        for target in (
            Target('bench_store', f'{name}.positions_per_s',
                   f'{label}, an hour of 25 tracks at 25 Hz, positions stored a second',
                   100_000 if name == 'sqlite' else None,
                   anchor='' if name == 'sqlite' else 'its settings as shipped'),
            Target('bench_store', f'{name}.bytes_per_position', f'{label}, bytes a position: '
                   'place, covariance, ids and index', None, 60 if name == 'sqlite' else None,
                   f'the other columns: `{name}.rest_bytes_per_position`'),
            Target('bench_store', f'{name}.query_ms', f'{label}, within 3 m of a track in a '
                   'minute, ms', None, 5 if name == 'sqlite' else None,
                   f'of a point: `{name}.point_query_ms`'),
        )
    ),
    Target('bench_store_long', 'month.positions_per_s', 'SQLite after a month (extrapolated from '
           'a day), positions stored a second',
           anchor='in the first hour: `first.positions_per_s`, the last: `last.positions_per_s`'),
    Target('bench_store_long', 'month.gigabytes', 'the same, size, GB',
           anchor='a day: `last.gigabytes`'),
    Target('bench_store_long', 'month.query_ms', 'the same, within 3 m of a track in a minute, ms',
           anchor='after an hour: `first.query_ms`, a day: `last.query_ms`'),
    *(
        Target('bench_streams', f'{way}.{form}.kb_per_s', 'stream of 25 targets at 25 Hz, '
               f'{words}, {by}, kB a second', None, 40)
        for form, words in (('tracks_xml', 'trajectory XML'), ('tracks_json', 'JSON'),
                            ('onvif_xml', 'ONVIF metadata'))
        for way, by in (('http', 'HTTP'), ('socket', 'web socket'))
    ),
    Target('bench_streams', 'mqtt.kb_per_s', 'the same, ONVIF JSON by MQTT, not compressed, five '
           'frames a second, kB a second', None, 40),
    Target('bench_streams', 'hostile.p99_ratio', 'two hundred slow or hostile readers, 99 of 100 '
           "ticks of fusion's latency, over that without them", None, 1.1,
           '95 % interval: `hostile.p99_ratio.low` to `hostile.p99_ratio.high`'),
    *(
        target
        for name, label in (
            ('store', 'the store node'), ('database', 'PostgreSQL'), ('fusion', 'the fusion node'),
        )
        for target in (
            Target('bench_kills', f'{name}.missing_s', f'{label} killed 50 times while 25 tracks '
                   'come at 25 Hz, most that is missing of a kill, s', None, 0.5,
                   {'store': 'away, median: `store.away_s`',
                    'database': 'of all kills; caught up: `database.caught_up_s`',
                    'fusion': 'of what others heard since the store did'}[name]),
            Target('bench_kills', f'{name}.faults', 'the same, what the checks after each kill '
                   'find', None, 0),
        )
    ),
    Target('bench_chaos', 'worst.named_s', 'fifteen faults in a live graph (nodes killed, cameras '
           'silent, late, lossy, with a wrong clock, disks full and read-only), seconds until '
           '/diagnostics names it, the worst', None, 2.0,
           'each: `FAULT.named_s`, a status comes once a second'),
    Target('bench_chaos', 'worst.ids_kept', 'the same, people with the same id afterwards, share, '
           'the worst', 1.0, None, 'fusion was away for `killed_fusion.pause_s`'),
    Target('bench_chaos', 'worst.lost', 'the same, recorded tracks that are missing', None, 0,
           'recorder killed, disk full'),
    Target('bench_chaos', 'worst.shutdown_s', 'SIGINT and SIGTERM to each node, seconds until it '
           'has ended, the worst', None, 1.0, 'each: `shutdown.NODE.SIGNAL_s`'),
    Target('bench_zones', 'tick.p50_ms', 'zone events, 25 tracks, 10 zones, 4 lines, median, ms',
           most=1, anchor='99 of 100 ticks: `tick.p99_ms`'),
    Target('bench_zones', 'crossings.wrong_share', 'crossings of lines counted beside the true '
           'ones, wrong, share', None, 0.05, 'without hysteresis: `crossings.raw_wrong_share`'),
    Target('bench_cells', 'cells.overlap.kept', 'site of 100 cameras in 4 to 8 cells, ids kept '
           'where cells overlap', 0.95, None, 'one fusion node: `one.overlap.kept`'),
    Target('bench_cells', 'cells.gap.kept', 'the same, across a strip of 2 m that nobody sees',
           None, None, 'one fusion node: `one.gap.kept`'),
    Target('bench_cells', 'cells.kept', 'the same, all borders', 0.95, None,
           'one fusion node: `one.kept`'),
    Target('bench_cells', 'cells.mota', 'the same, MOTA at 1 m', None, None,
           'one fusion node: `one.mota`'),
    Target('bench_cells', 'cells.idf1', 'the same, IDF1', None, None,
           'one fusion node: `one.idf1`'),
    Target('bench_cells', 'site.core', 'the same, share of a core that fusion of the cells takes',
           None, None, 'a cell: `cell.core`; one fusion node: `one.core`'),
    Target('bench_cells_live', 'kept', 'the same live, four cells and their site as nodes, ids '
           'kept over all borders', 0.95, None, 'at once: `at_once`'),
    Target('bench_cells_live', 'cell.core', 'the same, share of a core of the node of a cell of '
           '25 cameras, messages and all', None, None,
           'the worst: `cell.core_worst`; the site: `site.core`'),
    Target('bench_map', 'core_share', 'live map, 25 tracks at 10 Hz, one browser: share of a core '
           'that the server takes', None, 0.15),
    Target('bench_map', 'frames_per_s', 'the same, frames that the page draws a second'),
    Target('bench_replay', 'hashes', 'pitch, 100 replays in any order of arrival by 1 to 3 '
           'processes, different hashes of the tracks', most=1),
    Target('bench_replay', 'flips.found', 'the same, of 20 changed bits, found', 20),
    Target('bench_replay', 'detections.realtime_factor',
           'the same, speed from recorded detections, times real time', 10),
    Target('bench_replay', 'pictures.realtime_factor',
           'five cameras, speed from images on two cores, times real time', 3),
    Target('bench_live_replay', 'other_hashes', 'live runs at 0.5 to 1000 times the speed, whose '
           '/ticks are the same and whose tracks are not', most=0, anchor='runs verified by a '
           'replay: `verified` of `runs`; share with the most frequent /ticks: '
           '`same_ticks_share`'),
    Target('bench_recording', 'recorder.core_share',
           'recorder, five cameras at 25 Hz and all outputs, share of a core', most=0.25),
    Target('bench_recording', 'recorder.missing', 'the same, messages not recorded', most=0),
    Target('bench_recording', 'player.spacing_p99_ms',
           'player at rate 1, spacing of messages off by, 99 of 100, ms', most=2),
    Target('bench_fuzz', 'codec.faults', 'malformed clouds and images through the codec, crashes '
           'and wrong results', most=0, anchor='of `codec.messages`; refused: `codec.refused`; '
           'longest, ms: `codec.worst_ms`'),
    Target('bench_fuzz', 'live.uncounted', 'malformed clouds and images by DDS into a running '
           'graph, not counted as refused', most=0, anchor='of `live.messages`; exceptions: '
           '`live.exceptions`; nodes started again: `live.restarts`'),
    Target('bench_fuzz', 'live.same_tracks', "the same, the other cameras' tracks as without them",
           1),
    Target('bench_soak', 'memory.growth', 'small site live, growth of memory after the first ten '
           'minutes, of the process that grows most', most=0.01,
           anchor='fusion, cameras: `memory.fusion.growth`, `memory.cam1_camera.growth`; store, '
           'recorder: `memory.store.growth`, `memory.recorder.growth`'),
    Target('bench_soak', 'latency.p99_ratio', 'the same, 99 of 100 ticks, latency over that of '
           'the first ten minutes', most=1.1, anchor='ms: `latency.rest.p99_ms` over '
           '`latency.first.p99_ms`; medians: `latency.rest.p50_ms` over '
           '`latency.first.p50_ms`'),
    Target('bench_occupancy', 'square.p99_ms', 'occupancy, 40 x 40 m, 8 cameras, 20 people, '
           '99 of 100 ticks, ms', most=100, anchor='mean: `square.mean_ms`'),
    Target('bench_occupancy', 'square.gate_half_metre.mota', 'the same, MOTA at 0.5 m', None, None,
           'MODA: `square.gate_half_metre.moda`'),
    Target('bench_occupancy', 'square.nees', 'the same, squared errors of people over predicted '
           'ones', anchor='an honest prediction: 2'),
    Target('bench_occupancy', 'terrace.mean_ms', 'occupancy, terrace, four cameras, a tick, ms',
           most=10, anchor='99 of 100: `terrace.p99_ms`'),
    Target('bench_occupancy', 'terrace.nees', 'the same, squared errors over predicted ones',
           anchor='if its truth were exact: `terrace.nees_if_truth_were_exact`'),
    Target('scenarios', 'ghost.told_credulous.dies.rate', 'ghosts told of, dead within 1 s', 1.0),
    Target('scenarios', 'ghost.two_cameras.dies.rate', 'ghosts of two cameras, the same', 1.0),
    Target('scenarios', 'coalescence.side_by_side.same.weighed_gnn.kept.rate',
           'two of a kit side by side, ids kept'),
    Target('scenarios', 'coalescence.side_by_side.same.jpda.kept.rate', 'the same, JPDA'),
    Target('scenarios', 'hand_over.overlap.two_same.kept.rate',
           'two of a kit to the next camera, ids kept'),
    Target('scenarios', 'hand_over.blind.two_same.kept.rate', 'the same, 3 to 6 m unseen'),
    Target('scenarios', 'blind_area.one.kept.rate', 'hidden for 2 to 4 s, id kept'),
    Target('scenarios', 'blind_area.two_same.kept.rate', 'two of a kit, the same'),
    Target('scenarios', 'swapped_kits.scrum.right.rate', 'after a scrum of four, kits right'),
    Target('scenarios', 'swapped_kits.pair_alike.corrected.rate',
           'two who look the same, ids changed', most=0.0),
    Target('consistency', 'model.nees_inside', 'NEES in its 95 % band, share of ticks', 0.9),
    Target('consistency', 'walking.map.difference', 'error map, measured from predicted',
           most=0.25),
    *(
        Target('bench_fusion', f'{scene}.p50_ms', f'core tick, {words}, median, ms', most=most)
        for scene, words, most in (
            ('t25c5', '25 targets, 5 cameras', 0.4),
            ('t100c5', '100 targets, 5 cameras', 0.6),
            ('t1000c20_cov3', '1000 targets, 3 of 20 cameras on each', 4.0),
            ('t1000c20', '1000 targets, 12 of 20 cameras on each', 8.0),
        )
    ),
    *(
        Target('bench_fusion', f'{scene}.norfair_ratio', f'norfair over ours, {words}', least)
        for scene, words, least in (
            ('t25c5', '25 targets', 3.5),
            ('t100c5', '100 targets', 10.0),
            ('t1000c5', '1000 targets, 5 cameras', 60.0),
            ('t1000c20_cov3', '1000 targets, 3 of 20 cameras on each', 60.0),
        )
    ),
    Target('bench_fusion', 't25c5.stonesoup_gnn_ratio', 'Stone Soup, gated GNN, over ours', 150),
    Target('bench_fusion', 't1000c5.growth', 'time from 100 to 1000 targets', most=6),
    Target('bench_fusion', 'whole.p50_ms', 'whole tick, 25 targets, median, ms', most=2),
    Target('bench_fusion', 'hostile.worst_ms', 'worst tick of any bad input, ms', most=40),
    Target('bench_fusion', 'base.mota', 'base scenes, held out, MOTA at 1 m', 0.998, None,
           'norfair: `base.norfair.mota`'),
    Target('bench_fusion', 'base.idf1', 'base scenes, IDF1', 0.985, None,
           'norfair: `base.norfair.idf1`'),
    Target('bench_fusion', 'base.switches', 'base scenes, switches in 1000 ticks', None, None,
           'norfair: `base.norfair.switches`'),
    Target('bench_fusion', 'base.position_error_ratio',
           "base scenes, position error over the true association's", most=1.05),
    Target('bench_fusion', 'crowd.mota', 'crowds, held out, MOTA at 1 m', 0.995, None,
           'norfair: `crowd.norfair.mota`'),
    Target('bench_fusion', 'crowd.idf1', 'crowds, IDF1', 0.95, None,
           'norfair: `crowd.norfair.idf1`; on seeds 11 to 34 textbook GNN .823, JPDA .839'),
    Target('bench_fusion', 'crowd.switches', 'crowds, switches in 1000 ticks', None, None,
           'norfair: `crowd.norfair.switches`; on seeds 11 to 34 textbook GNN 22.8, JPDA 23.0'),
    *(
        Target('clocks', f'offset_{ms}ms.worst_ms',
               f'a clock {ms} ms ahead, largest error after 60 s of a match, ms', None, 5.0,
               f'rms `offset_{ms}ms.rms_ms`; of all trials within 5 ms: `within_5ms`')
        for ms in (0, 20, 50, 120)
    ),
    Target('clocks', 'coverage', 'the same, truth within the 95 % interval, share of 50', 0.90,
           None, 'of all cameras: `coverage_all`; half the interval: `half_ms` ms'),
    Target('clocks', 'still.known', 'the same while nobody moves, clocks that count as known',
           None, 0),
    Target('clocks', 'pixels.change_error_worst_ms',
           'one rendered match, a clock shifted by 20 to 120 ms: change less shift, worst, ms',
           None, 5.0, 'unshifted, truth 0: `pixels.unshifted_ms` +- `pixels.half_ms` ms'),
    *(
        Target('clocks', f'{name}.change_error_worst_ms',
               f'{words}, the same', None, 40.0,
               f'unshifted, truth unknown: `{name}.unshifted_ms` +- `{name}.half_ms` ms')
        for name, words in (
            ('terrace4', 'terrace, four cameras at 3 Hz'),
            ('terrace', 'terrace, two videos at 25 Hz'),
        )
    ),
)  # fmt: skip
"""In the order in which the page of results lists them: real data first."""
