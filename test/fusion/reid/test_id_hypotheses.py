from mctrack_ros.fusion.reid.id_hypotheses import Suspects


def test_one_is_himself_until_he_meets_another():
    suspects = Suspects()
    assert suspects.of(1) == {1}
    suspects.meet(1, 2)
    assert suspects.of(1) == suspects.of(2) == {1, 2}


def test_one_may_be_whomever_those_may_be_that_he_meets():
    suspects = Suspects()
    suspects.meet(1, 2)
    suspects.meet(2, 3)
    assert suspects.of(3) == suspects.of(2) == {1, 2, 3}
    assert suspects.of(1) == {1, 2}
    assert suspects.circle(1, [1, 2, 3, 4]) == [1, 2, 3]


def test_who_ended_may_still_be_another_and_who_is_erased_may_not():
    suspects = Suspects()
    suspects.meet(1, 2)
    suspects.meet(1, 3)
    suspects.end(2)
    assert suspects.of(1) == {1, 2, 3}
    suspects.erase([2])
    assert suspects.of(1) == {1, 3}


def test_those_who_settled_are_in_no_circle_but_their_own():
    suspects = Suspects()
    suspects.meet(1, 2)
    suspects.settle(1, ())
    suspects.settle(2, ())
    assert suspects.circle(1, [1, 2]) == [1]


def test_who_turned_out_to_be_another_is_nobodys_name_any_more():
    suspects = Suspects()
    suspects.meet(1, 7)
    suspects.end(7)
    suspects.become(7, 2)
    assert suspects.of(1) == {1, 2}
    assert suspects.of(7) == {7}
