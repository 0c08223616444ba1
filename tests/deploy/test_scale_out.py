# SPDX-License-Identifier: MIT
"""Servers that are killed, cut off, drained and added in the middle of many jobs: none is lost.

Three hosts in network namespaces, by HAProxy's configuration of deploy/haproxy and by the client
alone. Every test leaves a row in out/deploy/scale-out.md.
"""
import os
import shutil
import signal
import tempfile
import time
import unittest

from network import BIN, ROOT, Jobs, Limnd, Network, run, wait_until
from report import Report

REPORT = Report("scale-out.md", ["way", "what happens", "jobs", "lost", "jobs per server",
                                 "seconds in all", "slowest job, s", "noticed or ended after, s"])


class ScaleOut(unittest.TestCase):
    way = ""
    # How far a server's share may be from a third.
    slack = 0.1

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="limn-deploy-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.network = Network(self.folder)
        self.addCleanup(self.network.close)
        self.mesh = os.path.join(self.folder, "given.obj")
        run(f"{BIN}/limn", "generate", "irregular_sphere", "--vertices", "2000", "-o", self.mesh)
        self.servers = []
        for number in (1, 2, 3):
            self.add_server(number)

    def add_server(self, number, *flags):
        self.network.add_host(number)
        self.servers.append(Limnd(self.network, number, *flags))
        return self.servers[-1]

    def submit(self, jobs, **options):
        return Jobs(self.network, self.target(), self.mesh, jobs, **options)

    def counts(self):
        return [server.done()[0] for server in self.servers]

    def check(self, result, what, before, after=None):
        """None lost, and all answers the same bits."""
        counts = [now - then for now, then in zip(self.counts(), before)]
        REPORT.add(self.way, what, result["jobs"], result["failed"],
                   " / ".join(str(count) for count in counts), f"{result['seconds']:.1f}",
                   f"{result['slowest']:.2f}", "" if after is None else f"{after:.2f}")
        self.assertEqual(result["failed"], 0, result["errors"])
        self.assertEqual(result["digests"], 1)
        return counts

    def warm(self):
        """Until every server has had a job."""
        def all_have_worked():
            self.assertEqual(self.submit(12).finish()["failed"], 0)
            return min(self.counts()) > 0
        wait_until(all_have_worked, 30, "all servers have worked")


class Common:
    """Tests of both ways."""

    def test_balance(self):
        before = self.counts()
        counts = self.check(self.submit(900).finish(), "nothing", before)
        self.assertGreaterEqual(min(counts), (1 - self.slack) * 300, counts)
        self.assertLessEqual(max(counts), (1 + self.slack) * 300, counts)

    def test_uploads_of_one_connection_do_not_stop_each_other(self):
        self.mesh = os.path.join(self.folder, "large.obj")
        run(f"{BIN}/limn", "generate", "irregular_sphere", "--vertices", "20000", "-o", self.mesh)
        before = self.counts()
        result = self.submit(200, parallel=24, level=1).finish()
        self.check(result, "24 uploads of 880 KB at a time", before)
        self.assertLess(result["slowest"], 20)

    def test_kill(self):
        before = self.counts()
        jobs = self.submit(1500)
        jobs.wait_for(300)
        self.servers[1].kill()
        counts = self.check(jobs.finish(), "server 2 killed (-9)", before)
        self.assertLess(counts[1], counts[0])

    def test_partition(self):
        before = self.counts()
        jobs = self.submit(1500)
        jobs.wait_for(300)
        self.network.cut(2)
        result = jobs.finish()
        self.network.heal(2)
        healed = time.monotonic()
        count = self.servers[1].done()[0]

        def back():
            self.assertEqual(self.submit(12).finish()["failed"], 0)
            return self.servers[1].done()[0] > count
        wait_until(back, 40, "server 2 gets jobs again")
        self.check(result, "server 2 cut off, jobs again when healed", before,
                   time.monotonic() - healed)

    def test_drain(self):
        before = self.counts()
        jobs = self.submit(1500)
        jobs.wait_for(300)
        begin = time.monotonic()
        self.servers[2].terminate()
        self.assertEqual(self.servers[2].process.wait(40), 0)
        ended = time.monotonic() - begin
        self.check(jobs.finish(), "server 3 told to stop (SIGTERM)", before, ended)
        self.assertLess(ended, 10)


class ByProxy(Common, ScaleOut):
    way = "HAProxy"
    # Who is faster is free sooner, and has the fewest calls.
    slack = 0.6

    def setUp(self):
        super().setUp()
        self.write_servers()
        self.haproxy = self.network.start(
            "haproxy", "haproxy", "-W", "-f", f"{ROOT}/deploy/haproxy/haproxy.cfg", "-f",
            f"{self.folder}/servers.cfg",
            env={"LIMN_HAPROXY_SOCKET": f"{self.folder}/haproxy.sock"})
        wait_until(lambda: self.network.call(
            f"{BIN}/limn", "health", f"--server={self.target()}").returncode == 0, 20, "proxy")
        self.warm()

    def target(self):
        return f"{Network.HUB_ADDRESS}:7410"

    def write_servers(self):
        with open(f"{self.folder}/servers.cfg", "w") as file:
            file.write("backend limnd from limn\n")
            for server in self.servers:
                file.write(f"  server {server.name} {server.address} tcp-ut 10s\n")

    def test_add(self):
        before = self.counts() + [0]
        jobs = self.submit(1500)
        jobs.wait_for(300)
        added = self.add_server(4)
        begin = time.monotonic()
        self.write_servers()
        self.haproxy.send_signal(signal.SIGUSR2)
        wait_until(lambda: added.done()[0] > 0 or jobs.process.poll() is not None, 30, "it works")
        after = time.monotonic() - begin
        result = jobs.finish()
        self.check(result, "server 4 added, proxy reloaded", before, after)
        self.assertGreater(added.done()[0], 0)


class ByClient(Common, ScaleOut):
    way = "client, list of addresses"

    def setUp(self):
        super().setUp()
        self.warm()

    def target(self):
        return ",".join(server.address for server in self.servers[:3])


class ByName(ScaleOut):
    way = "client, one name"
    NAME = "limnd.example"

    def setUp(self):
        self.addCleanup(lambda: shutil.rmtree(self.hosts_folder, ignore_errors=True))
        super().setUp()

    def add_server(self, number, *flags):
        # Connections that end now and then, so that names are looked up again.
        server = super().add_server(number, "--max-connection-age=2", *flags)
        # What `ip netns exec` puts in the place of /etc/hosts.
        self.hosts_folder = f"/etc/netns/{self.network.hub}"
        os.makedirs(self.hosts_folder, exist_ok=True)
        with open(f"{self.hosts_folder}/hosts", "w") as file:
            for known in self.servers:
                file.write(f"{known.address.split(':')[0]} {self.NAME}\n")
        return server

    def target(self):
        return f"{self.NAME}:7410"

    def test_add(self):
        self.warm()
        before = self.counts() + [0]
        jobs = self.submit(3000)
        jobs.wait_for(300)
        added = self.add_server(4)
        begin = time.monotonic()
        wait_until(lambda: added.done()[0] > 0 or jobs.process.poll() is not None, 30, "it works")
        after = time.monotonic() - begin
        self.check(jobs.finish(), "server 4 added to the name", before, after)
        self.assertGreater(added.done()[0], 0)


if __name__ == "__main__":
    unittest.main()
