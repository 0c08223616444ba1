// SPDX-License-Identifier: MIT
// limnd as a process whose metrics are at hand, and clients that behave badly.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/client.h"
#include "tests/e2e/process.h"
#include "tests/server/service_fixture.h"

namespace limn::robustness {

// A server with metrics.
class Subject {
 public:
  // As e2e::ServerProcess.
  explicit Subject(const std::vector<std::string>& flags = {},
                   const std::vector<std::string>& prefix = {}, const std::string& preload = "");

  e2e::ServerProcess& server() { return *server_; }
  const std::string& address() const { return server_->address(); }
  int port() const;
  // A connection of its own.
  std::shared_ptr<grpc::Channel> Connect() const;
  // A whole small job on a connection of its own.
  absl::Status SmallJob() const;

  // All metrics; empty when the server does not answer.
  std::string Metrics() const;
  // A value; -1 when it is not there.
  double Metric(const std::string& series) const;
  // Waits until it has the value.
  bool WaitForMetric(const std::string& series, double value, double seconds = 20) const;
  // No stream, no job, no memory set aside.
  bool WaitUntilIdle(double seconds = 20) const;

  const e2e::Workspace& space() const { return space_; }
  e2e::Workspace& space() { return space_; }

 private:
  e2e::Workspace space_;
  std::unique_ptr<e2e::ServerProcess> server_;
  int metrics_port_ = 0;
};

// A socket that is connected to the port on the loopback address; -1 when that fails.
int Dial(int port);

// A TCP connection that sends what it is told and reads nothing.
class BareConnection {
 public:
  explicit BareConnection(int port, const std::string& bytes = "");
  ~BareConnection();
  BareConnection(const BareConnection&) = delete;
  BareConnection& operator=(const BareConnection&) = delete;
  bool connected() const { return connected_; }
  // Whether the other side closes it within so long.
  bool Closed(double seconds) const;

 private:
  int fd_ = -1;
  bool connected_ = false;
};

// Whether the long forms are asked for: LIMN_ROBUSTNESS=full in the environment.
bool Full();

// Smallest value that at least this part of the values does not exceed.
double Quantile(std::vector<double> values, double part);

}  // namespace limn::robustness
