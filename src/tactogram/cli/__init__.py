"""The command line: ``tactogram VERB``. Nothing heavy is imported before a verb is chosen."""

from tactogram.cli.command import main as main
