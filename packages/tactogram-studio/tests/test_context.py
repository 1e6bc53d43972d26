"""A studio on a folder."""

import numpy as np

from tactogram.signal import Signal
from tactogram_studio.context import Studio


def test_what_a_studio_keeps_lies_in_its_workspace(tmp_path):
    studio = Studio.at(tmp_path)
    kept = studio.shelf.keep(Signal(np.ones((1, 100)), 100.0, "1"), title="Ones", facts={})
    assert kept.file.is_relative_to(studio.workspace.studio_folder)
    assert studio.workspace.folder == tmp_path
    assert studio.roots == ()


def test_a_study_alone_is_served_if_asked_for(tmp_path):
    assert [Studio.at(tmp_path, study_only=alone).study_only for alone in (False, True)] == [False, True]
