# SPDX-License-Identifier: MIT
"""deploy/haproxy/servers-dns.cfg: servers come and go as the addresses of a name do."""
import os
import shutil
import signal
import tempfile
import unittest

from network import BIN, ROOT, Jobs, Limnd, Network, run, wait_until

NAME = "limnd.example"


class ProxyNames(unittest.TestCase):
    def test_servers_follow_the_name(self):
        folder = tempfile.mkdtemp(prefix="limn-deploy-")
        self.addCleanup(shutil.rmtree, folder)
        network = Network(folder)
        self.addCleanup(network.close)
        # What `ip netns exec` puts in the place of /etc/resolv.conf.
        own = f"/etc/netns/{network.hub}"
        os.makedirs(own)
        self.addCleanup(shutil.rmtree, own)
        with open(f"{own}/resolv.conf", "w") as file:
            file.write("nameserver 127.0.0.1\n")
        mesh = os.path.join(folder, "given.obj")
        run(f"{BIN}/limn", "generate", "irregular_sphere", "--vertices", "2000", "-o", mesh)

        def name(servers):
            with open(f"{folder}/hosts", "w") as file:
                for server in servers:
                    file.write(f"{server.address.split(':')[0]} {NAME}\n")

        def add(number):
            network.add_host(number)
            return Limnd(network, number)

        servers = [add(1), add(2)]
        name(servers)
        names = network.start("dnsmasq", "dnsmasq", "--no-daemon", "--no-resolv", "--no-hosts",
                              f"--addn-hosts={folder}/hosts", "--user=root", "--pid-file=")
        network.start("haproxy", "haproxy", "-W", "-f", f"{ROOT}/deploy/haproxy/haproxy.cfg", "-f",
                      f"{ROOT}/deploy/haproxy/servers-dns.cfg",
                      env={"LIMN_HAPROXY_SOCKET": f"{folder}/sock", "LIMN_SERVERS": f"{NAME}:7410"})
        proxy = f"{Network.HUB_ADDRESS}:7410"

        def submit(jobs):
            return Jobs(network, proxy, mesh, jobs)

        def all_work():
            before = [server.done()[0] for server in servers]
            self.assertEqual(submit(12).finish()["failed"], 0)
            return all(server.done()[0] > then for server, then in zip(servers, before))
        wait_until(lambda: network.call(f"{BIN}/limn", "health",
                                        f"--server={proxy}").returncode == 0, 30, "it serves")
        wait_until(all_work, 30, "both servers work")

        jobs = submit(2000)
        jobs.wait_for(200)
        servers.append(add(3))
        name(servers)
        names.send_signal(signal.SIGHUP)
        wait_until(lambda: servers[2].done()[0] > 0, 30, "the third server works")
        gone = servers.pop(0)
        name(servers)
        names.send_signal(signal.SIGHUP)
        gone.terminate()
        self.assertEqual(gone.process.wait(40), 0)
        result = jobs.finish()
        self.assertEqual(result["failed"], 0, result["errors"])
        wait_until(all_work, 30, "the others work on")


if __name__ == "__main__":
    unittest.main()
