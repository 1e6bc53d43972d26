"""Experiments with people: designs, the session store, what comes out of it."""

from tactogram.study.answers import Answer as Answer
from tactogram.study.answers import Answers as Answers
from tactogram.study.answers import read_answers as read_answers
from tactogram.study.answers import write_answers as write_answers
