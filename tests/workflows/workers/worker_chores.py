"""Tasks for workers: what they do is named by the task."""

import os
import signal
import time
from pathlib import Path

from tactogram.errors import ParameterError


def trained(seed):
    """A few steps of a small network: its weights depend on the order of every sum."""
    import torch  # here: the other chores start faster without it

    with torch.random.fork_rng():
        torch.manual_seed(seed)
        network = torch.nn.Sequential(torch.nn.Conv1d(4, 32, 9), torch.nn.ReLU(), torch.nn.Conv1d(32, 1, 9))
    x = torch.randn(16, 4, 300, generator=torch.Generator().manual_seed(seed))
    for _ in range(3):  # by hand: a process's first optimiser imports torch's compiler
        slopes = torch.autograd.grad(network(x).square().mean(), list(network.parameters()))
        with torch.no_grad():
            for weight, slope in zip(network.parameters(), slopes, strict=True):
                weight.sub_(0.01 * slope / slope.norm())
    return [float(p.detach().double().sum()) for p in network.parameters()], torch.get_num_threads()


def refused(number):
    if number == 1:
        raise ParameterError("number must be 0 or 2,\ngot 1")
    return number


def broken(number):
    raise ZeroDivisionError(f"{number} is a bug")


def deadly_once(file):
    """End the worker, but not the next one with the same task."""
    path = Path(file)
    if path.name.startswith("deadly") and not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return path.name


def always_deadly(number):
    if number:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def waits(task):
    """Say that it runs, on which process, and wait for a file."""
    folder, name = task
    Path(folder, f"{name}.{os.getpid()}.started").touch()
    until(Path(folder, "go").exists)
    return name


def counted(task):
    """Leave a trace of every attempt."""
    folder, number = task
    Path(folder, f"{number}.{time.monotonic_ns()}").touch()
    time.sleep(0.2)
    return {"square": number**2}


def until(true, seconds=300.0):
    """Wait for something, not for ever."""
    deadline = time.monotonic() + seconds
    while not true():
        if time.monotonic() > deadline:
            raise TimeoutError(f"not so within {seconds:g} s")
        time.sleep(0.05)
