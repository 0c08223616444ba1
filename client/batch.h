// SPDX-License-Identifier: MIT
// Many jobs on one stream, which is made anew when it breaks; see proto/limn/v1/batch.proto.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/client.h"
#include "engine/mesh/polygon_mesh.h"
#include "limn/v1/interpolate.pb.h"

namespace limn {

struct BatchJob {
  // 1 to 128 visible ASCII characters; no other job of the batch that is not answered has it.
  std::string id;
  // As for Client::Submit; without a request_id it gets the job's id.
  v1::InterpolateHeader header;
  // Not ok: the job fails with this, and nothing is sent.
  absl::StatusOr<PolygonMesh> mesh;
};

struct BatchResult {
  std::string id;
  // What Client::Run would give.
  absl::StatusOr<JobResult> result;
  // SHA-256 of the batch's name, the header and the encoded mesh, 32 bytes; empty if nothing was
  // encoded.
  std::string digest = {};
  // From the first byte sent to the last byte of the answer.
  double seconds = 0;
  // How often the job was begun at a server; more than once after errors that may be retried, and
  // where a server did not know it any more after its stream had broken.
  std::uint32_t tries = 0;
};

// How far the batch is, in jobs.
struct BatchTotals {
  // Taken from the source.
  std::uint64_t taken = 0;
  std::uint64_t succeeded = 0;
  // Failed or cancelled.
  std::uint64_t failed = 0;
};

// But for `next` they are called one at a time, on Run's thread or one of the batch's own. While
// one runs, no further answers are read: who is slow holds the server back.
struct BatchCallbacks {
  // The next job; nothing: there are no more. Called when there is room for it, on a thread of its
  // own, one call at a time, at the same time as the others.
  std::function<std::optional<BatchJob>()> next;
  // A job has ended; every job that `next` gave ends once. When this has returned ok, the server
  // may forget the answer. Otherwise the batch ends with what was returned, and nothing is called
  // any more.
  std::function<absl::Status(BatchResult)> on_result;
  // May be empty.
  std::function<void(const std::string& id, const v1::Progress&)> on_job_progress = {};
  std::function<void(const BatchTotals&)> on_totals = {};
};

struct BatchOptions {
  // Jobs that are sent and not answered at a time, at the most. 0: the server's limit
  // "batch-window".
  std::uint32_t window = 0;
  // No further job is taken while the encoded meshes of those that are not answered, which are kept
  // to be sent again, have as many bytes.
  std::uint64_t mesh_bytes = std::uint64_t{256} << 20;
  // Streams in a row on which no job came any further, before the batch ends with the last one's
  // error; and how often one job may fail with an error that may be retried, or be under way when a
  // stream breaks: ten times as often while servers take it up again. At least 1.
  std::uint32_t max_tries = 10;
  // Before the second try; each further one doubles it, up to the longest.
  std::chrono::milliseconds first_pause{100};
  std::chrono::milliseconds longest_pause{5000};
  // Part of every digest. Batches of other names never take up each other's jobs, though they have
  // the same ids and meshes; the same batch begun anew, by a program that was killed, may.
  std::string name = {};
};

// A batch. Jobs are sent and answered at the same time, all to one server, and where there are
// several to another one when that goes away. ClientOptions::deadline_seconds is a job's time from
// when it is first sent, its waiting at the server included.
class ClientBatch {
 public:
  // client: its channel and options are shared.
  explicit ClientBatch(const Client& client, BatchOptions options = {});
  ~ClientBatch();
  ClientBatch(const ClientBatch&) = delete;
  ClientBatch& operator=(const ClientBatch&) = delete;

  // Until all jobs of the source have ended. Ok: also if some of them failed. No job is answered
  // twice, and none is computed twice by a server that still knows it, whatever becomes of the
  // connections: jobs under way are named again to the server, which has their meshes sent again
  // only if it has lost them. Call it once.
  //
  // Errors, with which all jobs end that were taken and not answered: those of the server for the
  // whole stream that waiting does not cure (UNAUTHENTICATED, INVALID_ARGUMENT, UNIMPLEMENTED);
  // what ended the last of options.max_tries streams; CANCELLED after Cancel; INVALID_OPTION; what
  // on_result returned. UNREACHABLE at once when there is no server in the beginning.
  [[nodiscard]] absl::Status Run(const BatchCallbacks& callbacks);

  // Takes no more jobs, and cancels those under way, on the server too; those which it does not
  // confirm within five seconds end all the same. Thread-safe; before Run it has the same effect.
  void Cancel();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace limn
