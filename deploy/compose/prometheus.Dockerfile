# SPDX-License-Identifier: MIT
# Prometheus of Debian with the rules of deploy/monitoring. Context: the project's folder.
FROM debian:bookworm-slim
RUN apt-get update -q && \
    apt-get install -q -y --no-install-recommends prometheus && \
    rm -rf /var/lib/apt/lists/*
COPY deploy/monitoring/alerts.yml deploy/compose/prometheus.yml /etc/limn/
USER 65532:65532
ENTRYPOINT ["prometheus", "--config.file=/etc/limn/prometheus.yml", \
            "--storage.tsdb.path=/prometheus", "--web.listen-address=:9090"]
