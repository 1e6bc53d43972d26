"""Experiments with people: designs, the session store, what comes out of it."""

from tactogram.study.answers import Answer as Answer
from tactogram.study.answers import Answers as Answers
from tactogram.study.answers import read_answers as read_answers
from tactogram.study.answers import write_answers as write_answers
from tactogram.study.session.store import SessionStore as SessionStore
from tactogram.study.session.store import SubmissionResult as SubmissionResult
from tactogram.study.study_file import Study as Study
from tactogram.study.study_file import shipped_studies as shipped_studies
from tactogram.study.trials import Page as Page
from tactogram.study.trials import Participant as Participant
