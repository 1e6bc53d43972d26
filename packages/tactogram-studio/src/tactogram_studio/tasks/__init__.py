"""The studio's long tasks: processes of the command line that outlive the server, in a queue."""
