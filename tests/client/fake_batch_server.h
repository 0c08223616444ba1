// SPDX-License-Identifier: MIT
// A server's Batch rpc that does what a test says: it breaks off, forgets, answers in odd orders,
// and keeps books. A job's answer is its own mesh as the control mesh.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "limn/v1/limn.grpc.pb.h"

namespace limn {

class FakeBatchServer final : public v1::LimnService::Service {
 public:
  // Something that just happened on a stream.
  struct Event {
    enum class Kind { kHeader, kAccepted, kChunk, kComplete, kHalfAnswered, kAnswered };
    Kind kind = Kind::kHeader;
    std::string id;
    // Streams count from 0, events of a kind on their stream from 1.
    int stream = 0;
    int count = 0;
  };

  // What is set before the first call.
  struct Script {
    std::uint32_t window = 4;
    std::uint64_t max_message_bytes = std::uint64_t{2} << 20;
    // Not ok: the stream ends with it, here and now.
    std::function<grpc::Status(const Event&)> on_event = {};
    // Whether complete jobs with a digest outlive their stream.
    bool resume = true;
    // Answers wait until so many are there, and come interleaved, the last job's first.
    std::size_t hold = 1;
    // Errors that a job gets, one for each try, before it is answered.
    std::map<std::string, std::vector<absl::Status>> errors = {};
    // Jobs that are never answered, but by CANCELLED when they are cancelled.
    std::set<std::string> silent = {};
    // Cancellations are not heard.
    bool deaf = false;
    // All of an answer comes twice.
    bool stutter = false;
  };

  // What happened.
  struct Books {
    int streams = 0;
    // Headers in their order, over all streams.
    std::vector<std::string> headers;
    std::map<std::string, int> chunks;
    // How often a job was complete and worked on.
    std::map<std::string, int> worked;
    std::map<std::string, int> resumed;
    std::multiset<std::string> acknowledged;
    std::multiset<std::string> cancelled;
    // What no client may do.
    std::vector<std::string> violations;
  };

  explicit FakeBatchServer(Script script);
  ~FakeBatchServer() override;

  std::shared_ptr<grpc::Channel> Channel();
  Books books() const;

 private:
  struct Job;
  struct Stream;

  grpc::Status Batch(grpc::ServerContext* context,
                     grpc::ServerReaderWriter<v1::BatchResponse, v1::BatchRequest>* rpc) override;
  grpc::Status GetServerInfo(grpc::ServerContext* context, const v1::GetServerInfoRequest* request,
                             v1::GetServerInfoResponse* response) override;

  grpc::Status Take(const v1::BatchRequest& request, Stream* stream);
  grpc::Status TakeHeader(const v1::BatchRequest& request, Stream* stream);
  grpc::Status TakeChunk(const v1::BatchRequest& request, Stream* stream);
  grpc::Status Cancel(const std::string& id, Stream* stream);
  grpc::Status Work(const std::string& id, Stream* stream);
  grpc::Status AnswerHeld(Stream* stream);
  grpc::Status Tell(Event::Kind kind, const std::string& id, Stream* stream);

  Script script_;
  mutable std::mutex mutex_;
  Books books_;
  std::map<std::string, Job> kept_;
  std::unique_ptr<grpc::Server> server_;
};

}  // namespace limn
