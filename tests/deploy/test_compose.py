# SPDX-License-Identifier: MIT
"""deploy/compose by podman-compose, and deploy/kubernetes' small overlay by `podman kube play`."""
import json
import os
import shutil
import tempfile
import unittest
import urllib.request

import yaml

import containers
from containers import call, podman
from network import BIN, ROOT, run, wait_until
from test_manifests import kustomize

COMPOSE = ["podman-compose", "-f", f"{ROOT}/deploy/compose/compose.yaml"]
PORT = 17411


def targets():
    with urllib.request.urlopen("http://127.0.0.1:9090/api/v1/targets", timeout=5) as answer:
        found = json.load(answer)["data"]["activeTargets"]
    return {target["scrapeUrl"]: target["health"] for target in found}


def query(expression):
    url = f"http://127.0.0.1:9090/api/v1/query?query={urllib.request.quote(expression)}"
    with urllib.request.urlopen(url, timeout=5) as answer:
        return json.load(answer)["data"]["result"]


@unittest.skipUnless(containers.AVAILABLE and shutil.which("podman-compose"),
                     containers.WHY_NOT + ", or podman-compose")
class Compose(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.addClassCleanup(call, *COMPOSE, "down")
        containers.build("compose/build")
        result = call(*COMPOSE, "up", "-d")
        if result.returncode != 0:
            raise AssertionError(result.stdout + result.stderr)
        wait_until(cls.healthy, 30, "the stack serves")

    @staticmethod
    def healthy():
        return call(f"{BIN}/limn", "health", "--server=127.0.0.1:7410").returncode == 0

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="limn-deploy-")
        self.addCleanup(shutil.rmtree, self.folder)
        self.given = os.path.join(self.folder, "given.obj")
        run(f"{BIN}/limn", "generate", "irregular_sphere", "--vertices", "2000", "-o", self.given)

    def submit(self, jobs):
        return call(f"{BIN}/submit_jobs", "127.0.0.1:7410", self.given, str(jobs), "4", "1")

    def test_both_servers_work_and_prometheus_sees_it(self):
        result = self.submit(100)
        self.assertEqual(result.returncode, 0, result.stdout[-2000:])
        wait_until(lambda: targets() and set(targets().values()) == {"up"}, 40, "all are scraped")
        self.assertEqual(len(targets()), 3)

        def shares():
            done = query('sum by (instance) (limn_requests_total{code="OK",method="Interpolate"})')
            return {entry["metric"]["instance"]: float(entry["value"][1]) for entry in done}
        wait_until(lambda: len(shares()) == 2 and min(shares().values()) > 25, 30,
                   "both servers have done more than a quarter of the jobs")

    def test_a_restarted_server_is_found_again(self):
        name = next(name for name in podman("ps", "--format", "{{.Names}}").split()
                    if "limnd1" in name)
        podman("kill", name)
        self.assertEqual(self.submit(50).returncode, 0)
        podman("start", name)
        count = podman("logs", name).count("event=job")

        def works_again():
            self.assertEqual(self.submit(20).returncode, 0)
            result = call("podman", "logs", name)
            return (result.stdout + result.stderr).count("event=job") > count
        wait_until(works_again, 40, "it gets jobs again")


@unittest.skipUnless(containers.AVAILABLE and (shutil.which("kubectl") or shutil.which("kustomize")),
                     containers.WHY_NOT + ", or no kubectl or kustomize")
class KubePlay(unittest.TestCase):
    def test_the_small_overlay_runs(self):
        containers.build("container/build")
        deployment = next(doc for doc in kustomize(f"{ROOT}/deploy/kubernetes/overlays/small")
                          if doc["kind"] == "Deployment")
        # There is no cluster's network here: the port is published on loopback instead.
        container = deployment["spec"]["template"]["spec"]["containers"][0]
        container["ports"] = [{"containerPort": 7410, "hostPort": PORT, "hostIP": "127.0.0.1"}]
        container["image"] = "localhost/" + container["image"]
        container["imagePullPolicy"] = "Never"
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            yaml.safe_dump(deployment, file)
            file.flush()
            self.addCleanup(call, "podman", "pod", "rm", "-f", "-t", "0", "limnd-pod-0")
            podman("kube", "play", file.name)
        wait_until(lambda: call(f"{BIN}/limn", "health",
                                f"--server=127.0.0.1:{PORT}").returncode == 0, 20, "it serves")
        inspected = podman("inspect", "limnd-pod-0-limnd", "--format", "{{.Config.User}} "
                           "{{.HostConfig.ReadonlyRootfs}} {{.EffectiveCaps}} {{.HostConfig.Memory}}")
        self.assertEqual(inspected, f"65532:65532 true [] {1 << 30}")


if __name__ == "__main__":
    unittest.main()
