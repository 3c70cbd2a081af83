"""What a learner's node does not have to survive, ours survives."""
import importlib

import pytest
from aruco_ar.painting.sources import Still
from aruco_ar.runner import Runner
from aruco_ar.settings.settings import PictureSettings
from aruco_course.check import Check, Shown
from aruco_course.exercises import CHECKS

CHALLENGES = [(check, challenge) for check in CHECKS if isinstance(check, Check)
              for challenge in check.challenges]


def shown_by(exercise, number, view):
    """What an exercise makes of a view that it sees as its first frame."""
    runner = Runner(exercise, [PictureSettings()], lambda _: Still(view.picture))
    return Shown(number, view, tuple(runner.run(view.frame, 1.0, keeps_frame=True)[1]))


@pytest.mark.parametrize('check, challenge', CHALLENGES, ids=['%s-%s' % (check.number, challenge.name)
                                                              for check, challenge in CHALLENGES])
def test_our_node_survives(check, challenge):
    exercise = importlib.import_module(check.name).EXERCISE
    fault = challenge.judge([shown_by(exercise, *each) for each in enumerate(challenge.views(), start=1)])
    assert fault is None, str(fault)


def test_there_are_challenges_for_each_node():
    assert {check.number for check, _ in CHALLENGES} == {'5.2', '5.3', '5.4', '5.5', '5.6'}
    assert len(CHALLENGES) > 20
