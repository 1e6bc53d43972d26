"""Ratings: words on scales of steps."""

from tactogram.study.designs.rating.design import WordRating as WordRating
