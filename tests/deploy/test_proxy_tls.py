# SPDX-License-Identifier: MIT
"""deploy/haproxy with TLS on both sides, over loopback in a namespace of its own."""
import os
import shutil
import tempfile
import time
import unittest

from network import BIN, ROOT, Network, run, wait_until


class ProxyTls(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="limn-deploy-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.network = Network(self.folder)
        self.addCleanup(self.network.close)
        os.mkdir(self.path("tls"))
        run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
            "-nodes", "-days", "1", "-subj", "/CN=limnd", "-addext",
            "subjectAltName=DNS:limnd,DNS:limn", "-keyout", self.path("tls/limn.pem.key"), "-out",
            self.path("tls/limn.pem"))
        shutil.copy(self.path("tls/limn.pem"), self.path("tls/ca.pem"))
        with open(self.path("tokens"), "w") as file:
            file.write("somebody a-token-of-twenty-four-c\n")
        run(f"{BIN}/limn", "generate", "irregular_sphere", "--vertices", "500", "-o",
            self.path("given.obj"))

    def path(self, name):
        return os.path.join(self.folder, name)

    def limn(self, *arguments):
        return self.network.call(f"{BIN}/limn", *arguments)

    def start(self, server_tls):
        for number in (1, 2):
            flags = [f"--tls-cert={self.path('tls/limn.pem')}",
                     f"--tls-key={self.path('tls/limn.pem.key')}"] if server_tls else []
            self.network.start(f"limnd{number}", f"{BIN}/limnd", f"--listen=127.0.0.1:741{number}",
                               f"--token-file={self.path('tokens')}", "--threads=1", *flags)
        self.network.start(
            "haproxy", "haproxy", "-W", "-f", f"{ROOT}/deploy/haproxy/haproxy.cfg", "-f",
            f"{ROOT}/deploy/haproxy/servers.cfg",
            env={"LIMN_HAPROXY_SOCKET": self.path("sock"), "LIMN_TLS": self.path("tls")})

    def test_jobs_and_health_with_tls_all_the_way(self):
        self.start(server_tls=True)
        tls = ["--server=127.0.0.1:7410", f"--tls-ca={self.path('tls/ca.pem')}", "--tls-name=limn"]
        wait_until(lambda: self.limn("health", *tls).returncode == 0, 20, "it serves")
        job = ["interpolate", self.path("given.obj"), "-q", "-o", self.path("s.obj"), *tls]

        def both_have_worked():
            done = self.limn(*job, f"--token-file={self.path('tokens')}")
            self.assertEqual(done.returncode, 0, done.stderr)
            return all("client=somebody" in self.network.log(f"limnd{number}")
                       for number in (1, 2))
        wait_until(both_have_worked, 10, "both servers have worked")
        # Their health goes on being seen.
        time.sleep(4)
        self.assertNotIn("is DOWN", self.network.log("haproxy").split("is UP")[-1])
        self.assertTrue(both_have_worked())
        self.assertEqual(self.limn(*job).returncode, 3)
        self.assertEqual(self.limn("health", "--server=127.0.0.1:7410").returncode, 3)
        self.assertEqual(self.limn("health", *tls[:2]).returncode, 3, "another name")

    def test_a_server_without_tls_is_not_used(self):
        self.start(server_tls=False)
        wait_until(lambda: self.network.log("haproxy").count("is DOWN") >= 2, 20, "both are down")
        health = self.limn("health", "--server=127.0.0.1:7410",
                           f"--tls-ca={self.path('tls/ca.pem')}", "--tls-name=limn")
        self.assertEqual(health.returncode, 3)


if __name__ == "__main__":
    unittest.main()
