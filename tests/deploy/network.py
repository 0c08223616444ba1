# SPDX-License-Identifier: MIT
"""Several machines on one: network namespaces on a bridge, with a process in each.

The bridge and the client are in a namespace of their own too, so that nothing of the machine's own
network is touched, and two networks may exist side by side.
"""
import os
import re
import signal
import subprocess
import time

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
BIN = os.path.join(ROOT, "build", "release", "bin")


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def wait_until(condition, seconds, what):
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            raise AssertionError(f"not within {seconds} s: {what}")
        time.sleep(0.05)


class Network:
    """Hosts 10.77.0.1 to .9, and the hub, 10.77.0.254, where clients and proxies run."""

    HUB_ADDRESS = "10.77.0.254"

    def __init__(self, folder):
        self.folder = folder
        self.prefix = f"limn{os.getpid()}"
        self.hub = f"{self.prefix}-hub"
        self.hosts = []
        self.processes = []
        run("ip", "netns", "add", self.hub)
        run("ip", "-n", self.hub, "link", "set", "lo", "up")
        run("ip", "-n", self.hub, "link", "add", "bridge", "type", "bridge")
        run("ip", "-n", self.hub, "addr", "add", f"{self.HUB_ADDRESS}/24", "dev", "bridge")
        run("ip", "-n", self.hub, "link", "set", "bridge", "up")

    def add_host(self, number):
        name = f"{self.prefix}-{number}"
        run("ip", "netns", "add", name)
        self.hosts.append(name)
        run("ip", "-n", self.hub, "link", "add", f"v{number}", "type", "veth", "peer", "name", "eth0",
            "netns", name)
        run("ip", "-n", self.hub, "link", "set", f"v{number}", "master", "bridge", "up")
        run("ip", "-n", name, "addr", "add", f"10.77.0.{number}/24", "dev", "eth0")
        run("ip", "-n", name, "link", "set", "eth0", "up")
        run("ip", "-n", name, "link", "set", "lo", "up")

    def cut(self, number):
        """Nothing passes any more, and nobody is told."""
        run("ip", "-n", self.hub, "link", "set", f"v{number}", "nomaster")

    def heal(self, number):
        run("ip", "-n", self.hub, "link", "set", f"v{number}", "master", "bridge")

    def start(self, name, *command, host=None, env=None):
        """A process at a host, or at the hub. Its output goes to FOLDER/NAME.log."""
        space = self.hub if host is None else f"{self.prefix}-{host}"
        log = open(os.path.join(self.folder, f"{name}.log"), "a")
        process = subprocess.Popen(["ip", "netns", "exec", space, *command], stdout=log, stderr=log,
                                   env={**os.environ, **(env or {})}, start_new_session=True)
        log.close()
        self.processes.append(process)
        return process

    def call(self, *command, timeout=600):
        """A command at the hub, to its end."""
        return subprocess.run(["ip", "netns", "exec", self.hub, *command], capture_output=True,
                              text=True, timeout=timeout)

    def log(self, name):
        with open(os.path.join(self.folder, f"{name}.log")) as log:
            return log.read()

    def close(self):
        for process in self.processes:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        for name in [*self.hosts, self.hub]:
            subprocess.run(["ip", "netns", "del", name], check=False)


class Limnd:
    """A server at a host of its own, with one thread."""

    def __init__(self, network, number, *flags):
        self.network = network
        self.number = number
        self.name = f"limnd{number}"
        self.address = f"10.77.0.{number}:7410"
        self.process = network.start(
            self.name, f"{BIN}/limnd", f"--listen={self.address}", "--insecure", "--threads=1",
            *flags, host=number)
        wait_until(self.serves, 20, f"{self.name} serves")

    def serves(self):
        return self.network.call(f"{BIN}/limn", "health", f"--server={self.address}").returncode == 0

    def done(self):
        """Jobs that went well, and that did not."""
        log = self.network.log(self.name)
        codes = re.findall(r"event=job .*? code=(\w+)", log)
        return codes.count("OK"), len(codes) - codes.count("OK")

    def kill(self):
        os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    def terminate(self):
        self.process.send_signal(signal.SIGTERM)


class Jobs:
    """Many jobs over one connection from the hub, by tests/deploy/submit_jobs."""

    def __init__(self, network, servers, mesh, jobs, parallel=6, level=2, attempts=4):
        self.network = network
        self.name = f"jobs{len(network.processes)}"
        self.process = network.start(self.name, f"{BIN}/submit_jobs", servers, mesh, str(jobs),
                                     str(parallel), str(level), str(attempts))

    def ended(self):
        return len(re.findall(r" (?:ok|[A-Z_]+:.*)$", self.network.log(self.name), re.MULTILINE))

    def wait_for(self, count):
        wait_until(lambda: self.ended() >= count or self.process.poll() is not None, 120,
                   f"{count} jobs")

    def finish(self, timeout=180):
        """{"jobs", "failed", "digests", "seconds", "slowest", "errors"}"""
        self.process.wait(timeout)
        log = self.network.log(self.name)
        last = re.search(r"jobs=(\d+) failed=(\d+) digests=(\d+) seconds=([\d.]+)", log)
        if last is None:
            raise AssertionError(f"submit_jobs broke off: {log[-500:]}")
        lines = re.findall(r"^[\d.]+ ([\d.]+) (.*)$", log, re.MULTILINE)
        return {
            "jobs": int(last[1]),
            "failed": int(last[2]),
            "digests": int(last[3]),
            "seconds": float(last[4]),
            "slowest": max(float(latency) for latency, _ in lines),
            "errors": sorted({text for _, text in lines if text != "ok"}),
        }
