import sys

from tactogram_studio.workspace.starter_data import StarterData


def test_an_interrupted_preparation_starts_again(tmp_path):
    starter = StarterData(tmp_path / "first")
    (starter.store / "half").mkdir(parents=True)

    assert starter.state == "absent"
    starter._follow = lambda command: None
    starter._make()
    assert not (starter.store / "half").exists()


def test_the_page_says_why_the_preparation_failed(tmp_path):
    starter = StarterData(tmp_path)
    starter._follow([sys.executable, "-c", "print('learning'); raise SystemExit('no space is left')"])

    assert starter.state == "failed"
    assert starter.line == "the example surfaces could not be made: no space is left"
