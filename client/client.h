// SPDX-License-Identifier: MIT
// C++ client of limnd: connect, submit a job, iterate over what comes back, cancel; evaluate a
// surface.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/security.h"
#include "engine/base/vec3.h"
#include "engine/limit/evaluate.h"
#include "engine/limit/tessellation.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/evaluate.pb.h"
#include "limn/v1/interpolate.pb.h"
#include "limn/v1/server_info.pb.h"

namespace grpc {
class Channel;
}

namespace limn {

// One call, running. Not thread-safe except Cancel(); destroying it cancels what still runs.
template <class Request, class Response>
class ClientCall {
 public:
  ~ClientCall();
  ClientCall(ClientCall&&) noexcept;
  ClientCall& operator=(ClientCall&&) noexcept;

  // Waits for the next message of the answer. Nothing: the answer is complete, see Finish.
  std::optional<Response> Next();

  // Stops the job on the server too. Thread-safe; may be called from a signal-watching thread.
  void Cancel();

  // The call's end: ok, or the server's error with its detail (GetErrorDetail). Reads and drops
  // what Next was not called for.
  [[nodiscard]] absl::Status Finish();

 private:
  friend class Client;
  struct Impl;
  explicit ClientCall(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};
using ClientJob = ClientCall<v1::InterpolateRequest, v1::InterpolateResponse>;
using ClientEvaluation = ClientCall<v1::EvaluateRequest, v1::EvaluateResponse>;

// Everything that an Interpolate job gave.
struct JobResult {
  // With the faces of the input, or of the repaired mesh where that was asked for (lossless
  // encodings), when the control mesh was asked for.
  PolygonMesh control_mesh;
  // When the surface was asked for. Normals as doubles of the float32 that travelled.
  Tessellation surface;
  // summary.repair() has the mapping too; see wire::MappingElements.
  v1::Summary summary;
};

// Everything that an Evaluate call gave: one point, two derivatives and a normal per parameter, in
// their order, as SurfaceSamples describes them.
struct EvaluateResult {
  std::vector<Vec3> points;
  std::vector<Vec3> du;
  std::vector<Vec3> dv;
  std::vector<Vec3> normals;
  v1::Summary summary;
};

struct ClientOptions {
  // Time limit of a job, in seconds; 0 is none.
  double deadline_seconds = 0;
  // How often Run and Evaluate begin a job at the most whose server went away, each time on the
  // next server where there are several; see client/retry.h.
  int attempts = 4;
  // Bytes per chunk of the upload, 1 to 1 MiB.
  std::uint32_t chunk_bytes = 512U << 10;
  // Metadata of every call, in ASCII: "authorization: Bearer TOKEN", "traceparent" and the like.
  // Names in lower case.
  std::vector<std::pair<std::string, std::string>> metadata = {};
};

// A connection. Thread-safe: several jobs may run on it at once.
class Client {
 public:
  // address: one server or several that take turns, as ParseServers of client/servers.h has it.
  // Other targets of gRPC, such as "unix:PATH", are passed on as they are. Connects when the first
  // job needs it.
  static Client Connect(const std::string& address, const ClientOptions& options = {});
  // The same with TLS, a certificate, a token. Errors: INVALID_OPTION; see MakeChannel. What the
  // server thinks of them is seen with the first call.
  [[nodiscard]] static absl::StatusOr<Client> ConnectSecurely(const std::string& address,
                                                              const ClientSecurity& security,
                                                              ClientOptions options = {});
  // Over a channel made elsewhere, such as a server's in-process channel.
  explicit Client(std::shared_ptr<grpc::Channel> channel, const ClientOptions& options = {});

  // Starts a job: encodes the mesh as header.mesh().encoding() says (its counts are filled in) and
  // uploads it while answers can already be read. The mesh is not needed after the call returns.
  [[nodiscard]] absl::StatusOr<ClientJob> Submit(v1::InterpolateHeader header,
                                                 const PolygonMesh& mesh) const;

  // Submits, collects, finishes, and begins again, up to `attempts` times, where the server went
  // away. on_progress: called for each progress message; false cancels.
  using ProgressCallback = std::function<bool(const v1::Progress&)>;
  [[nodiscard]] absl::StatusOr<JobResult> Run(const v1::InterpolateHeader& header,
                                              const PolygonMesh& mesh,
                                              const ProgressCallback& on_progress = {}) const;

  // As Submit, for the samples of the job's surface at these parameters. The header asks for no
  // output. Parameters that make no sense are the server's to refuse.
  [[nodiscard]] absl::StatusOr<ClientEvaluation> SubmitEvaluation(
      v1::InterpolateHeader header, const PolygonMesh& mesh,
      std::vector<SurfaceParameter> parameters) const;

  // Submits, collects, finishes, and begins again as Run does.
  [[nodiscard]] absl::StatusOr<EvaluateResult> Evaluate(
      const v1::InterpolateHeader& header, const PolygonMesh& mesh,
      const std::vector<SurfaceParameter>& parameters,
      const ProgressCallback& on_progress = {}) const;

  [[nodiscard]] absl::StatusOr<v1::GetServerInfoResponse> GetServerInfo() const;

  // Whether a server, of several at least one, says of this service that it serves, by
  // grpc.health.v1: "" and "limn.v1.LimnService" are readiness, "liveness" is what its name says.
  [[nodiscard]] absl::StatusOr<bool> Serves(const std::string& service) const;

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }
  const ClientOptions& options() const { return options_; }
  // The same connection, with other options.
  Client With(const ClientOptions& options) const { return Client(channel_, options); }

 private:
  std::shared_ptr<grpc::Channel> channel_;
  ClientOptions options_;
};

// Takes all of a call's answer to so many parameters and finishes it. on_progress: as in
// Client::Run. Errors: the
// call's; UNREACHABLE when the answer has no end; INTERNAL when it makes no sense.
[[nodiscard]] absl::StatusOr<EvaluateResult> CollectEvaluation(
    ClientEvaluation* call, std::size_t parameters, const Client::ProgressCallback& on_progress);

}  // namespace limn
