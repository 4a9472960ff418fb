from mctrack_ros.fusion.reid.id_hypotheses import IdHypotheses


def test_one_is_himself_until_he_meets_another():
    hypotheses = IdHypotheses()
    assert hypotheses.of(1) == {1}
    hypotheses.meet(1, 2)
    assert hypotheses.of(1) == hypotheses.of(2) == {1, 2}


def test_one_may_be_whomever_those_may_be_that_he_meets():
    hypotheses = IdHypotheses()
    hypotheses.meet(1, 2)
    hypotheses.meet(2, 3)
    assert hypotheses.of(3) == hypotheses.of(2) == {1, 2, 3}
    assert hypotheses.of(1) == {1, 2}
    assert hypotheses.connected(1, [1, 2, 3, 4]) == [1, 2, 3]


def test_who_ended_may_still_be_another_and_who_is_erased_may_not():
    hypotheses = IdHypotheses()
    hypotheses.meet(1, 2)
    hypotheses.meet(1, 3)
    hypotheses.end(2)
    assert hypotheses.of(1) == {1, 2, 3}
    hypotheses.erase([2])
    assert hypotheses.of(1) == {1, 3}


def test_those_who_settled_are_in_no_circle_but_their_own():
    hypotheses = IdHypotheses()
    hypotheses.meet(1, 2)
    hypotheses.settle(1, ())
    hypotheses.settle(2, ())
    assert hypotheses.connected(1, [1, 2]) == [1]


def test_who_turned_out_to_be_another_is_nobodys_name_any_more():
    hypotheses = IdHypotheses()
    hypotheses.meet(1, 7)
    hypotheses.end(7)
    hypotheses.become(7, 2)
    assert hypotheses.of(1) == {1, 2}
    assert hypotheses.of(7) == {7}
