"""An S3-like server on loopback (moto, in an environment of its own)."""

import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from lightning_fabric.plugins.environments.lightning import find_free_network_port

SERVER = Path(sys.prefix) / "s3" / "bin" / "moto_server"  # by `make install`


@contextmanager
def object_store() -> Iterator[str]:
    """Run the server, name it in the environment, make the bucket ``bucket``, and yield the server's address."""
    port = find_free_network_port()
    known = {
        "AWS_ACCESS_KEY_ID": "testing",
        "AWS_SECRET_ACCESS_KEY": "testing",
        "AWS_REGION": "us-east-1",
        "AWS_EC2_METADATA_DISABLED": "true",
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{port}",
    }
    process = subprocess.Popen(
        [SERVER, "-H", "127.0.0.1", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        until = time.monotonic() + 60
        while not _answers(port) and time.monotonic() < until and process.poll() is None:
            time.sleep(0.05)
        make = (
            "import pyarrow.fs as fs; fs.S3FileSystem(allow_bucket_creation=True, scheme='http', "
            f"endpoint_override='127.0.0.1:{port}').create_dir('bucket')"
        )
        with patch.dict("os.environ", known):
            # In a process of its own: Arrow's S3 does not survive the forks of the fuzzer.
            subprocess.run([sys.executable, "-c", make], check=True)
            yield known["AWS_ENDPOINT_URL"]
    finally:
        process.terminate()
        process.wait()


def _answers(port: int) -> bool:
    with socket.socket() as tried:
        return tried.connect_ex(("127.0.0.1", port)) == 0
