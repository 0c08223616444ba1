# SPDX-License-Identifier: MIT
# HAProxy of Debian with deploy/haproxy. Context: the project's folder.
FROM debian:bookworm-slim
RUN apt-get update -q && \
    apt-get install -q -y --no-install-recommends haproxy && \
    rm -rf /var/lib/apt/lists/*
COPY deploy/haproxy/haproxy.cfg deploy/compose/servers.cfg /etc/limn/
USER 65532:65532
ENTRYPOINT ["haproxy", "-W", "-f", "/etc/limn/haproxy.cfg", "-f", "/etc/limn/servers.cfg"]
