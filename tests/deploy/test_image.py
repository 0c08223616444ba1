# SPDX-License-Identifier: MIT
"""The image of deploy/container: what is in it, what it may do, and that it gives the same bits."""
import filecmp
import os
import shutil
import tarfile
import tempfile
import unittest

import containers
from containers import Container, call, podman
from network import BIN, ROOT, run, wait_until

CONFINED = ["--read-only", "--cap-drop", "all", "--security-opt", "no-new-privileges", "--memory",
            "512m", "--cpus", "1", "--pids-limit", "128"]
OPEN = ["--listen", "0.0.0.0:7410", "--insecure"]
PORT = 17410
CONTENT = "{{.RootFS.Layers}} {{.Config}} {{.Created}}"
ADDRESS = f"127.0.0.1:{PORT}"


def health(*flags):
    return call(f"{BIN}/limn", "health", f"--server={ADDRESS}", *flags)


@unittest.skipUnless(containers.AVAILABLE, containers.WHY_NOT)
class Image(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        containers.build("container/build")

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="limn-deploy-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.given = os.path.join(self.folder, "given.obj")
        run(f"{BIN}/limn", "generate", "irregular_sphere", "--vertices", "3000", "-o", self.given)

    def start(self, *arguments, flags=()):
        container = Container(*CONFINED, "-p", f"{ADDRESS}:7410", *flags, "limn", *arguments)
        self.addCleanup(container.remove)
        return container

    def serve(self, *arguments, flags=()):
        container = self.start(*arguments, flags=flags)
        wait_until(lambda: container.exec("/usr/bin/limn", "health").returncode == 0, 20,
                   f"it serves: {container.log()}")
        return container

    def interpolate(self, out, *flags):
        path = os.path.join(self.folder, out)
        run(f"{BIN}/limn", "interpolate", self.given, "-q", "-o", path, *flags)
        return path

    def test_a_confined_container_gives_the_same_bits(self):
        self.serve(*OPEN)
        inside = self.interpolate("inside.obj", f"--server={ADDRESS}")
        outside = self.interpolate("outside.obj")
        self.assertTrue(filecmp.cmp(inside, outside, shallow=False))

    def test_it_is_nobody_with_a_read_only_root_and_no_capabilities(self):
        container = self.serve(*OPEN)
        self.assertEqual(container.inspect("{{.Config.User}}"), "65532:65532")
        self.assertEqual(container.inspect("{{.HostConfig.ReadonlyRootfs}}"), "true")
        self.assertEqual(container.inspect("{{.EffectiveCaps}}"), "[]")
        pid = container.inspect("{{.State.Pid}}")
        with open(f"/proc/{pid}/status") as file:
            status = dict(line.rstrip().split(":\t", 1) for line in file if ":\t" in line)
        self.assertEqual(status["Uid"].split()[0], "65532")
        self.assertEqual(int(status["CapEff"], 16), 0)
        self.assertEqual(int(status["CapBnd"], 16), 0)
        self.assertEqual(status["NoNewPrivs"].strip(), "1")

    def test_threads_follow_the_quota(self):
        self.assertIn("threads=1", self.serve(*OPEN).log())

    def test_health(self):
        container = self.serve(*OPEN)
        podman("healthcheck", "run", container.id)
        self.assertEqual(container.inspect("{{.State.Healthcheck.Status}}"), "healthy")
        self.assertEqual(health().stdout, "SERVING\n")

    def test_a_hung_server_is_unhealthy(self):
        container = self.serve(*OPEN)
        podman("pause", container.id)
        self.assertEqual(health("--deadline=1").returncode, 3)
        podman("unpause", container.id)
        self.assertEqual(health().returncode, 0)

    def test_health_with_tls_by_the_environment(self):
        key, certificate = (os.path.join(self.folder, name) for name in ("key.pem", "cert.pem"))
        run("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
            "-nodes", "-days", "1", "-subj", "/CN=limnd", "-addext", "subjectAltName=DNS:limnd",
            "-keyout", key, "-out", certificate)
        os.chmod(self.folder, 0o755)
        os.chmod(key, 0o644)
        container = self.serve(
            "--listen=0.0.0.0:7410", "--tls-cert=/tls/cert.pem", "--tls-key=/tls/key.pem",
            flags=["-v", f"{self.folder}:/tls:ro", "-e", "LIMN_HEALTH_TLS_CA=/tls/cert.pem", "-e",
                   "LIMN_HEALTH_TLS_NAME=limnd"])
        podman("healthcheck", "run", container.id)
        self.assertEqual(health().returncode, 3)
        secure = [f"--tls-ca={certificate}", "--tls-name=limnd"]
        self.assertEqual(health(*secure).returncode, 0)
        self.assertEqual(health(f"--tls-ca={certificate}").returncode, 3)
        self.interpolate("tls.obj", f"--server={ADDRESS}", *secure)

    def test_it_ends_with_zero(self):
        self.assertEqual(self.serve(*OPEN).stop(), 0)

    def test_by_default_nobody_outside_reaches_it(self):
        container = self.serve()
        self.assertEqual(health("--deadline=2").returncode, 3)
        self.assertIn("address=127.0.0.1:7410", container.log())

    def test_it_refuses_others_without_tls(self):
        container = self.start("--listen", "0.0.0.0:7410")
        podman("wait", container.id)
        self.assertEqual(container.inspect("{{.State.ExitCode}}"), "2")

    def test_what_is_in_it(self):
        container = self.start(*OPEN)
        path = os.path.join(self.folder, "image.tar")
        podman("export", "-o", path, container.id)
        with tarfile.open(path) as tar:
            names = set(tar.getnames())
            packages = tar.extractfile("usr/share/doc/limn/packages.txt").read().decode()
        self.assertLessEqual({"usr/bin/limnd", "usr/bin/limn"}, names)
        self.assertFalse([name for name in names if name.endswith(("bin/sh", "bin/apt"))])
        listed = [line.split("\t") for line in packages.splitlines()]
        self.assertTrue(all(len(line) == 4 and all(line) for line in listed), packages)
        self.assertLessEqual({"libc6", "libgrpc29", "libdraco7", "libtbb12"},
                             {line[0] for line in listed})
        for name, *_ in listed:
            self.assertIn(f"usr/share/doc/{name}/copyright", names)
        self.assertLess(int(podman("image", "inspect", "limn", "--format", "{{.Size}}")), 60e6)

    # The binaries come from the compiler again, if by its cache; all else is done anew.
    @unittest.skipUnless(os.environ.get("LIMN_DEPLOY") == "full", "LIMN_DEPLOY is not full")
    def test_built_again_it_is_the_same_image(self):
        first = podman("image", "inspect", "limn", "--format", CONTENT)
        script = os.path.join(ROOT, "deploy", "container", "build")
        result = call("env", "LIMN_BUILD_FLAGS=--no-cache", script, "limn:again")
        self.assertEqual(result.returncode, 0, result.stderr[-2000:])
        # All but the names of the layers that were on the way.
        self.assertEqual(podman("image", "inspect", "limn:again", "--format", CONTENT), first)


if __name__ == "__main__":
    unittest.main()
