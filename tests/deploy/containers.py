# SPDX-License-Identifier: MIT
"""podman with a store of the tests' own, in a way that works on plain machines too.

Images and containers are kept in out/deploy/containers, so that a second run builds little.
"""
import os
import shutil
import subprocess
import time

from network import ROOT
from report import FOLDER

STORE = os.path.join(FOLDER, "containers")
AVAILABLE = all(shutil.which(tool) for tool in ("podman", "runc", "mmdebstrap"))
WHY_NOT = "podman, runc or mmdebstrap is not there"


def environment():
    """Files that say where podman keeps what, and how it runs: without systemd, by runc."""
    os.makedirs(STORE, exist_ok=True)
    storage = os.path.join(STORE, "storage.conf")
    with open(storage, "w") as file:
        file.write(f'[storage]\ndriver = "overlay"\ngraphroot = "{STORE}/graph"\n'
                   f'runroot = "{STORE}/run"\n')
    engine = os.path.join(STORE, "containers.conf")
    with open(engine, "w") as file:
        file.write('[containers]\ndefault_ulimits = ["nofile=16384:16384", "nproc=4096:4096"]\n'
                   '[engine]\ncgroup_manager = "cgroupfs"\nruntime = "runc"\n'
                   'events_logger = "file"\n')
    return {**os.environ, "CONTAINERS_STORAGE_CONF": storage, "CONTAINERS_CONF": engine}


def call(*command, timeout=1800):
    return subprocess.run(command, env=environment(), cwd=ROOT, capture_output=True, text=True,
                          timeout=timeout)


def podman(*arguments):
    result = call("podman", *arguments)
    if result.returncode != 0:
        raise AssertionError(f"podman {' '.join(arguments)}: {result.stderr}")
    return result.stdout.strip()


def build(script):
    """Runs deploy/SCRIPT; what it prints is kept beside the tables."""
    begin = time.monotonic()
    result = call(f"deploy/{script}", timeout=3000)
    with open(os.path.join(FOLDER, script.replace("/", "-") + ".log"), "w") as log:
        log.write(result.stdout + result.stderr)
    if result.returncode != 0:
        raise AssertionError(f"deploy/{script}: {(result.stdout + result.stderr)[-3000:]}")
    return time.monotonic() - begin


class Container:
    """A container that is removed at the end."""

    def __init__(self, *arguments):
        self.id = podman("run", "-d", *arguments)

    def inspect(self, template):
        return podman("inspect", self.id, "--format", template)

    def exec(self, *command):
        return call("podman", "exec", self.id, *command)

    def log(self):
        result = call("podman", "logs", self.id)
        return result.stdout + result.stderr

    def stop(self, seconds=20):
        """Its exit status."""
        podman("stop", "-t", str(seconds), self.id)
        return int(self.inspect("{{.State.ExitCode}}"))

    def remove(self):
        call("podman", "rm", "-f", "-t", "0", self.id)
