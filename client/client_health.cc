// SPDX-License-Identifier: MIT
// grpc.health.v1 of the client. Its two messages have one field each and are written out here.
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <memory>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/client_call.h"
#include "engine/base/error.h"

namespace limn {
namespace {

// A length in one byte.
constexpr std::size_t kLongestName = 127;

// HealthCheckRequest{string service = 1}.
std::string HealthRequest(const std::string& service) {
  if (service.empty()) return "";
  return absl::StrCat("\x0a", std::string(1, static_cast<char>(service.size())), service);
}

// HealthCheckResponse{ServingStatus status = 1}, which is left out where it is 0.
bool Serves(const grpc::ByteBuffer& response) {
  std::vector<grpc::Slice> slices;
  std::string bytes;
  if (!response.Valid() || !response.Dump(&slices).ok()) return false;
  for (const grpc::Slice& slice : slices) {
    bytes.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  constexpr char kServing[] = "\x08\x01";
  return bytes == kServing;
}

}  // namespace

absl::StatusOr<bool> Client::Serves(const std::string& service) const {
  LIMN_RETURN_IF_ERROR(CheckClientOptions(options_));
  if (service.size() > kLongestName) {
    return MakeError("no service has so long a name",
                     {.reason = Reason::kInvalidOption, .field = "service"});
  }
  grpc::ClientContext context;
  PrepareCall(options_, &context);
  const grpc::Slice slice(HealthRequest(service));
  const grpc::ByteBuffer request(&slice, 1);
  grpc::ByteBuffer response;
  grpc::Status status;
  grpc::CompletionQueue done;
  grpc::GenericStub stub(channel_);
  const auto call = stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &done);
  call->StartCall();
  call->Finish(&response, &status, nullptr);
  void* tag = nullptr;
  bool ok = false;
  done.Next(&tag, &ok);
  if (!status.ok()) return wire::FromGrpcStatus(status);
  return limn::Serves(response);
}

}  // namespace limn
