"""Photographs and recordings of weak pairs: each once."""

from dataclasses import replace

from tests.features.test_photo_pairs import pairs, part, photo


class Counted(list):
    """Photographs that count how often they are read."""

    reads = 0

    def __getitem__(self, place):
        Counted.reads += 1
        return super().__getitem__(place)


def test_shared_photographs_are_read_once():
    class Looked(list):
        times = 0

        def __iter__(self):
            Looked.times += 1
            return super().__iter__()

    shown = Looked([photo(1)])
    many = [replace(example, photographs=shown) for example in part(1, materials=("cork",), recordings=50)]
    assert len(pairs(many).photo_sources) == 1
    assert Looked.times == 1


def test_a_photograph_of_two_materials_is_paired_with_both():
    shown = [photo(1)]
    both = [replace(example, photographs=shown) for example in part(1, materials=("cork", "felt"))]
    made = pairs(both)
    assert made.materials == ("cork", "felt")
    assert set(made.labels) == {0, 1}


def test_one_photograph_of_many_recordings_is_one_source():
    assert len(pairs().photo_sources) == 9
    assert len(pairs().recording_sources) == 12
