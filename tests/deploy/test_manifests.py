# SPDX-License-Identifier: MIT
"""deploy/kubernetes: what kustomize makes of it holds together, and with limnd's own flags."""
import json
import os
import re
import shutil
import subprocess
import unittest

import yaml

from network import BIN, ROOT, run
from report import FOLDER

OVERLAYS = ["small", "production"]
UNITS = {"": 1, "Ki": 2**10, "Mi": 2**20, "Gi": 2**30}
# What a server needs besides its jobs, and what estimates may be off by.
SPARE_BYTES = 256 << 20
# What limnd takes after --drain-seconds at the most, with some more.
SPARE_SECONDS = 12
MODELS = ["kubernetes-models@4.5.1", "@kubernetes-models/prometheus-operator@6.0.0"]


def in_bytes(quantity):
    number, unit = re.fullmatch(r"(\d+)(\w*)", str(quantity)).groups()
    return int(number) * UNITS[unit]


def kustomize(folder):
    tool = ["kubectl", "kustomize"] if shutil.which("kubectl") else ["kustomize", "build"]
    return [doc for doc in yaml.safe_load_all(run(*tool, folder)) if doc]


def known_flags():
    return set(re.findall(r"--[a-z-]+", run(f"{BIN}/limnd", "--help")))


@unittest.skipUnless(shutil.which("kubectl") or shutil.which("kustomize"),
                     "there is neither kubectl nor kustomize")
class Manifests(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.docs = {name: kustomize(f"{ROOT}/deploy/kubernetes/overlays/{name}")
                    for name in OVERLAYS}

    def each(self, kind):
        for docs in self.docs.values():
            for doc in docs:
                if doc["kind"] == kind:
                    yield docs, doc

    def containers(self):
        for docs, doc in self.each("Deployment"):
            pod = doc["spec"]["template"]["spec"]
            for container in pod["containers"]:
                yield pod, container

    def servers(self):
        for pod, container in self.containers():
            if container["name"] == "limnd":
                flags = dict(re.fullmatch(r"(--[a-z-]+)(?:=(.*))?", argument).groups()
                             for argument in container["args"])
                yield pod, container, flags

    def test_everything_is_in_the_namespace(self):
        for overlay, docs in self.docs.items():
            self.assertTrue(docs, overlay)
            for doc in docs:
                if doc["kind"] != "Namespace":
                    self.assertEqual(doc["metadata"].get("namespace"), "limn", doc["metadata"])

    def test_the_production_overlay_has_every_part(self):
        kinds = {doc["kind"] for doc in self.docs["production"]}
        self.assertLessEqual({"Deployment", "Service", "PodDisruptionBudget", "ConfigMap",
                              "HorizontalPodAutoscaler", "NetworkPolicy", "ServiceMonitor"}, kinds)

    def test_selectors_select_pods(self):
        def pods(docs):
            return [doc["spec"]["template"]["metadata"]["labels"] for doc in docs
                    if doc["kind"] == "Deployment"]

        def selects(docs, labels):
            return any(labels.items() <= pod.items() for pod in pods(docs))
        for docs, doc in self.each("Deployment"):
            labels = doc["spec"]["selector"]["matchLabels"]
            self.assertLessEqual(labels.items(),
                                 doc["spec"]["template"]["metadata"]["labels"].items())
        for docs, doc in self.each("Service"):
            self.assertTrue(selects(docs, doc["spec"]["selector"]))
        for docs, doc in self.each("PodDisruptionBudget"):
            self.assertTrue(selects(docs, doc["spec"]["selector"]["matchLabels"]))
        for docs, doc in self.each("NetworkPolicy"):
            self.assertTrue(selects(docs, doc["spec"]["podSelector"]["matchLabels"]))
        for docs, doc in self.each("ServiceMonitor"):
            services = [other for other in docs if other["kind"] == "Service"
                        and doc["spec"]["selector"]["matchLabels"].items()
                        <= other["metadata"]["labels"].items()]
            self.assertTrue(services)
            for endpoint in doc["spec"]["endpoints"]:
                self.assertIn(endpoint["port"],
                              [port["name"] for port in services[0]["spec"]["ports"]])
        for docs, doc in self.each("HorizontalPodAutoscaler"):
            target = doc["spec"]["scaleTargetRef"]["name"]
            scaled = [other for other in docs if other["kind"] == "Deployment"
                      and other["metadata"]["name"] == target]
            self.assertEqual(len(scaled), 1)
            self.assertNotIn("replicas", scaled[0]["spec"], "two would set them")

    def test_ports_have_names_that_services_know(self):
        for docs, doc in self.each("Service"):
            names = {port["name"] for other in docs if other["kind"] == "Deployment"
                     and doc["spec"]["selector"].items()
                     <= other["spec"]["template"]["metadata"]["labels"].items()
                     for container in other["spec"]["template"]["spec"]["containers"]
                     for port in container["ports"]}
            for port in doc["spec"]["ports"]:
                self.assertIn(port["targetPort"], names)

    def test_the_servers_service_is_headless(self):
        for _, doc in self.each("Service"):
            if doc["metadata"]["name"] == "limnd":
                self.assertEqual(doc["spec"]["clusterIP"], "None")

    def test_flags_are_limnds(self):
        known = known_flags()
        for _, container, flags in self.servers():
            self.assertLessEqual(set(flags), known)
            ports = {port["name"]: port["containerPort"] for port in container["ports"]}
            self.assertTrue(flags["--listen"].endswith(f":{ports['grpc']}"))
            self.assertTrue(flags["--metrics-listen"].endswith(f":{ports['metrics']}"))

    def test_limnd_takes_these_flags(self):
        for _, container, flags in self.servers():
            if "--tls-cert" in flags:
                continue
            arguments = [argument for argument in container["args"] if "listen" not in argument]
            process = subprocess.Popen([f"{BIN}/limnd", "--listen=127.0.0.1:0", *arguments],
                                       stderr=subprocess.PIPE, text=True)
            line = process.stderr.readline()
            process.terminate()
            self.assertEqual(process.wait(20), 0)
            process.stderr.close()
            self.assertIn("event=listening", line)

    def test_memory_limits_agree(self):
        for _, container, flags in self.servers():
            limit = in_bytes(container["resources"]["limits"]["memory"])
            total = int(flags["--max-total-bytes"])
            self.assertLessEqual(int(flags["--max-job-bytes"]), total)
            self.assertLessEqual(total + SPARE_BYTES, limit)

    def test_the_grace_period_is_long_enough(self):
        for pod, container, flags in self.servers():
            pause = container["lifecycle"]["preStop"]["sleep"]["seconds"]
            self.assertGreaterEqual(pod["terminationGracePeriodSeconds"],
                                    pause + int(flags["--drain-seconds"]) + SPARE_SECONDS)

    def test_containers_may_do_nothing(self):
        for pod, container in self.containers():
            security = container["securityContext"]
            self.assertTrue(pod["securityContext"]["runAsNonRoot"])
            self.assertFalse(pod["automountServiceAccountToken"])
            self.assertTrue(security["readOnlyRootFilesystem"])
            self.assertFalse(security["allowPrivilegeEscalation"])
            self.assertEqual(security["capabilities"], {"drop": ["ALL"]})
            self.assertIn("memory", container["resources"]["limits"])

    def test_mounts_have_volumes(self):
        for pod, container in self.containers():
            volumes = {volume["name"] for volume in pod.get("volumes", [])}
            for mount in container.get("volumeMounts", []):
                self.assertIn(mount["name"], volumes)
            self.assertEqual(volumes,
                             {mount["name"] for mount in container.get("volumeMounts", [])})

    def test_probes_speak_what_the_server_speaks(self):
        for _, container, flags in self.servers():
            for name in ("startupProbe", "readinessProbe", "livenessProbe"):
                probe = container[name]
                if "--tls-cert" in flags:
                    # The kubelet's own gRPC probe has no TLS.
                    self.assertEqual(probe["exec"]["command"][:2], ["/usr/bin/limn", "health"])
                    self.assertNotIn("grpc", probe)
                else:
                    self.assertEqual(probe["grpc"]["port"], 7410)

    def test_scaled_by_metrics_that_there_are(self):
        with open(f"{ROOT}/deploy/kubernetes/metrics-adapter.yaml") as file:
            rules = yaml.safe_load(file)["rules"]["custom"]
        with open(f"{ROOT}/server/metrics.cc") as file:
            source = file.read()
        made = set()
        for rule in rules:
            series = rule["seriesQuery"].split("{")[0]
            self.assertIn(f'"{series.removesuffix("_bucket")}"', source)
            name = rule.get("name", {"matches": "^(.*)$", "as": "${1}"})
            made.add(re.sub(name["matches"], name["as"].replace("${1}", r"\1"), series))
        for _, doc in self.each("HorizontalPodAutoscaler"):
            for metric in doc["spec"]["metrics"]:
                self.assertIn(metric["pods"]["metric"]["name"], made)

    @unittest.skipUnless(shutil.which("npm"), "there is no npm to fetch the schemas with")
    def test_schemas(self):
        folder = os.path.join(FOLDER, "npm")
        os.makedirs(folder, exist_ok=True)
        run("npm", "install", "--silent", "--no-audit", "--no-fund", "--prefix", folder, *MODELS)

        def problems(docs):
            return subprocess.run(
                ["node", f"{ROOT}/tests/deploy/schemas.js", f"{folder}/node_modules"],
                input=json.dumps(docs), capture_output=True, text=True).stdout
        for overlay, docs in self.docs.items():
            self.assertEqual(problems(docs), "", overlay)
        # And it does see what is wrong.
        broken = json.loads(json.dumps(self.docs["small"]))
        for doc in broken:
            if doc["kind"] == "Deployment":
                doc["spec"]["replicas"] = "one"
                doc["spec"]["template"]["spec"]["containers"][0]["readinesProbe"] = {}
        self.assertIn("replicas must be integer", problems(broken))
        self.assertIn("unknown field /spec/template/spec/containers/0/readinesProbe",
                      problems(broken))


if __name__ == "__main__":
    unittest.main()
