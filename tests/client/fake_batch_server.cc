// SPDX-License-Identifier: MIT
#include "tests/client/fake_batch_server.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "proto/wire/chunks.h"
#include "proto/wire/status.h"

namespace limn {

using Rpc = grpc::ServerReaderWriter<v1::BatchResponse, v1::BatchRequest>;

struct FakeBatchServer::Job {
  v1::InterpolateHeader header;
  std::string digest;
  std::optional<wire::ChunkAssembler> upload;
  std::string bytes;
};

struct FakeBatchServer::Stream {
  int number = 0;
  Rpc* rpc = nullptr;
  std::map<std::string, Job> jobs;
  // Whose chunks may come.
  std::string uploading;
  std::vector<std::string> held;
  std::map<Event::Kind, int> counts;

  void Write(const std::string& id, v1::InterpolateResponse response) const {
    v1::BatchResponse message;
    message.set_job_id(id);
    *message.mutable_response() = std::move(response);
    rpc->Write(message);
  }
  void Fail(const std::string& id, const absl::Status& status) const {
    v1::BatchResponse message;
    message.set_job_id(id);
    *message.mutable_error() = wire::ToRichStatus(status, id);
    rpc->Write(message);
  }
};

namespace {

v1::InterpolateResponse AcceptedOf(const std::string& id, bool resumed) {
  v1::InterpolateResponse response;
  response.mutable_accepted()->set_request_id(id);
  response.mutable_accepted()->set_resumed(resumed);
  return response;
}

v1::InterpolateResponse SummaryOf(const v1::InterpolateHeader& header) {
  v1::InterpolateResponse response;
  response.mutable_summary()->set_request_id(header.request_id());
  response.mutable_summary()->set_input_vertices(header.mesh().vertex_count());
  return response;
}

v1::InterpolateResponse ProgressOf(double fraction) {
  v1::InterpolateResponse response;
  response.mutable_progress()->set_stage("solve");
  response.mutable_progress()->set_fraction(fraction);
  return response;
}

// Header, then chunks.
std::vector<v1::InterpolateResponse> MeshParts(const v1::MeshHeader& header,
                                               const std::string& bytes) {
  std::vector<v1::InterpolateResponse> parts(1);
  *parts[0].mutable_control_mesh()->mutable_header() = header;
  wire::ChunkReader chunks(bytes, 300);
  v1::MeshChunk chunk;
  while (chunks.Next(&chunk)) *parts.emplace_back().mutable_control_mesh()->mutable_chunk() = chunk;
  return parts;
}

}  // namespace

FakeBatchServer::FakeBatchServer(Script script) : script_(std::move(script)) {
  grpc::ServerBuilder builder;
  builder.RegisterService(this);
  server_ = builder.BuildAndStart();
}

FakeBatchServer::~FakeBatchServer() { server_->Shutdown(std::chrono::system_clock::now()); }

std::shared_ptr<grpc::Channel> FakeBatchServer::Channel() { return server_->InProcessChannel({}); }

FakeBatchServer::Books FakeBatchServer::books() const {
  const std::lock_guard lock(mutex_);
  return books_;
}

grpc::Status FakeBatchServer::GetServerInfo(grpc::ServerContext* /*context*/,
                                            const v1::GetServerInfoRequest* /*request*/,
                                            v1::GetServerInfoResponse* response) {
  const auto add = [&](const char* name, std::uint64_t value) {
    v1::Limit& limit = *response->add_limits();
    limit.set_name(name);
    limit.set_value(value);
  };
  add("batch-window", script_.window);
  add("max-message-bytes", script_.max_message_bytes);
  return grpc::Status::OK;
}

grpc::Status FakeBatchServer::Batch(grpc::ServerContext* /*context*/, Rpc* rpc) {
  Stream stream;
  stream.rpc = rpc;
  {
    const std::lock_guard lock(mutex_);
    stream.number = books_.streams++;
  }
  v1::BatchRequest request;
  while (rpc->Read(&request)) {
    const std::lock_guard lock(mutex_);
    if (grpc::Status status = Take(request, &stream); !status.ok()) return status;
  }
  return grpc::Status::OK;
}

grpc::Status FakeBatchServer::Tell(Event::Kind kind, const std::string& id, Stream* stream) {
  const int count = ++stream->counts[kind];
  if (!script_.on_event) return grpc::Status::OK;
  return script_.on_event({.kind = kind, .id = id, .stream = stream->number, .count = count});
}

grpc::Status FakeBatchServer::Take(const v1::BatchRequest& request, Stream* stream) {
  const std::string& id = request.job_id();
  if (request.has_cancel()) return Cancel(id, stream);
  if (request.has_acknowledge()) {
    books_.acknowledged.insert(id);
    if (stream->jobs.contains(id)) books_.violations.push_back("acknowledged unanswered: " + id);
    kept_.erase(id);
    return grpc::Status::OK;
  }
  if (request.request().has_header()) return TakeHeader(request, stream);
  return TakeChunk(request, stream);
}

grpc::Status FakeBatchServer::TakeHeader(const v1::BatchRequest& request, Stream* stream) {
  const std::string& id = request.job_id();
  if (stream->jobs.contains(id)) books_.violations.push_back("sent twice at a time: " + id);
  if (request.digest().empty()) books_.violations.push_back("without a digest: " + id);
  const auto open = stream->jobs.find(stream->uploading);
  if (open != stream->jobs.end() && open->second.upload) {
    books_.violations.push_back("between the chunks of " + stream->uploading + ": " + id);
  }
  books_.headers.push_back(id);
  if (grpc::Status status = Tell(Event::Kind::kHeader, id, stream); !status.ok()) return status;
  const auto found = kept_.find(id);
  const bool resumed =
      script_.resume && found != kept_.end() && found->second.digest == request.digest();
  Job& job = stream->jobs[id];
  stream->uploading = id;
  if (resumed) {
    ++books_.resumed[id];
    job = found->second;
  } else {
    job.header = request.request().header();
    job.digest = request.digest();
    job.upload.emplace(job.header.mesh().byte_count());
  }
  stream->Write(id, AcceptedOf(id, resumed));
  if (grpc::Status status = Tell(Event::Kind::kAccepted, id, stream); !status.ok()) return status;
  return resumed ? Work(id, stream) : grpc::Status::OK;
}

grpc::Status FakeBatchServer::TakeChunk(const v1::BatchRequest& request, Stream* stream) {
  const std::string& id = request.job_id();
  ++books_.chunks[id];
  if (stream->uploading != id) books_.violations.push_back("chunk out of turn: " + id);
  const auto found = stream->jobs.find(id);
  if (found == stream->jobs.end() || !found->second.upload) return grpc::Status::OK;
  Job& job = found->second;
  if (grpc::Status status = Tell(Event::Kind::kChunk, id, stream); !status.ok()) return status;
  if (!job.upload->Add(request.request().chunk()).ok()) {
    books_.violations.push_back("broken mesh: " + id);
  }
  if (!job.upload->complete()) return grpc::Status::OK;
  job.bytes = job.upload->TakeBytes();
  job.upload.reset();
  ++books_.worked[id];
  kept_[id] = job;
  if (grpc::Status status = Tell(Event::Kind::kComplete, id, stream); !status.ok()) return status;
  return Work(id, stream);
}

grpc::Status FakeBatchServer::Cancel(const std::string& id, Stream* stream) {
  books_.cancelled.insert(id);
  if (script_.deaf || !stream->jobs.contains(id)) return grpc::Status::OK;
  stream->Fail(id, MakeError("cancelled", {.reason = Reason::kCancelled}));
  stream->jobs.erase(id);
  return grpc::Status::OK;
}

grpc::Status FakeBatchServer::Work(const std::string& id, Stream* stream) {
  if (script_.silent.contains(id)) return grpc::Status::OK;
  auto& errors = script_.errors[id];
  if (!errors.empty()) {
    stream->Fail(id, errors.front());
    errors.erase(errors.begin());
    stream->jobs.erase(id);
    return grpc::Status::OK;
  }
  stream->held.push_back(id);
  return stream->held.size() < script_.hold ? grpc::Status::OK : AnswerHeld(stream);
}

grpc::Status FakeBatchServer::AnswerHeld(Stream* stream) {
  std::reverse(stream->held.begin(), stream->held.end());
  std::map<std::string, std::vector<v1::InterpolateResponse>> answers;
  std::size_t longest = 0;
  for (const std::string& id : stream->held) {
    const Job& job = stream->jobs[id];
    auto& parts = answers[id] = MeshParts(job.header.mesh(), job.bytes);
    parts.insert(parts.begin(), ProgressOf(0.5));
    parts.push_back(SummaryOf(job.header));
    longest = std::max(longest, parts.size());
  }
  for (std::size_t part = 0; part < longest; ++part) {
    for (const std::string& id : stream->held) {
      const auto& parts = answers[id];
      if (part >= parts.size()) continue;
      stream->Write(id, parts[part]);
      const bool last = part + 1 == parts.size();
      if (last) stream->jobs.erase(id);
      if (last && script_.stutter) {
        for (const auto& again : parts) stream->Write(id, again);
        stream->Fail(id, absl::InternalError("again"));
        stream->Write("nobody", parts[0]);
      }
      const Event::Kind kind = last ? Event::Kind::kAnswered : Event::Kind::kHalfAnswered;
      if (grpc::Status status = Tell(kind, id, stream); !status.ok()) return status;
    }
  }
  stream->held.clear();
  return grpc::Status::OK;
}

}  // namespace limn
