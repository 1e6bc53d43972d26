"""Tables of a session file."""

FILE = "answers.sqlite"
VERSION = 4
"""The file's ``user_version``."""
TABLES = (
    "CREATE TABLE study (id INTEGER PRIMARY KEY CHECK (id = 1), facts TEXT NOT NULL, begun TEXT NOT NULL, "
    "withdrawn INTEGER NOT NULL DEFAULT 0, ended TEXT)",
    "CREATE TABLE participants (number INTEGER PRIMARY KEY, code TEXT NOT NULL UNIQUE COLLATE NOCASE, "
    "language TEXT NOT NULL, simulated INTEGER NOT NULL, session TEXT NOT NULL, status TEXT NOT NULL "
    "CHECK (status IN ('active', 'aborted')))",
    # Answered pages. The file enforces that a page is stored once, not the program.
    "CREATE TABLE pages (participant INTEGER NOT NULL REFERENCES participants, position INTEGER NOT NULL, "
    "token TEXT NOT NULL, responses TEXT NOT NULL, facts TEXT NOT NULL, "
    "PRIMARY KEY (participant, position), UNIQUE (participant, token))",
    # Rows as they were when answered: another version of the program cannot change them.
    "CREATE TABLE answers (participant INTEGER NOT NULL, position INTEGER NOT NULL, place INTEGER NOT NULL, "
    "row TEXT NOT NULL, PRIMARY KEY (participant, position, place), "
    "FOREIGN KEY (participant, position) REFERENCES pages (participant, position))",
    "CREATE TABLE played (id INTEGER PRIMARY KEY AUTOINCREMENT, participant INTEGER NOT NULL REFERENCES participants, "
    "token TEXT NOT NULL, slot TEXT NOT NULL, sha256 TEXT NOT NULL, level TEXT NOT NULL, display TEXT NOT NULL, "
    "gain_db REAL NOT NULL, at TEXT NOT NULL, facts TEXT NOT NULL DEFAULT '{}')",
    "CREATE INDEX played_by_page ON played (participant, token)",
    "CREATE TABLE notes (id INTEGER PRIMARY KEY AUTOINCREMENT, participant INTEGER REFERENCES participants, "
    "text TEXT NOT NULL, at TEXT NOT NULL)",
    # Device facts: with an answer, or with token "" when a participant began or continued.
    "CREATE TABLE device (id INTEGER PRIMARY KEY AUTOINCREMENT, participant INTEGER NOT NULL REFERENCES participants, "
    "token TEXT NOT NULL, facts TEXT NOT NULL, at TEXT NOT NULL)",
    "CREATE INDEX device_by_page ON device (participant, token)",
)
