// SPDX-License-Identifier: MIT
// The rpc Evaluate of the client.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/types/span.h"
#include "client/client_call.h"
#include "client/retry.h"
#include "engine/base/error.h"
#include "proto/wire/samples.h"

namespace limn {
namespace {

// Parameters per message: some hundred KiB up, a few messages down.
constexpr std::size_t kBlock = std::size_t{1} << 14;

absl::Status BadAnswer(std::string_view what) {
  return MakeError(absl::StrCat("the server's answer makes no sense: ", std::string(what)),
                   {.reason = Reason::kInternal, .remedy = "Use a server of this version"});
}

}  // namespace

template class ClientCall<v1::EvaluateRequest, v1::EvaluateResponse>;

absl::StatusOr<ClientEvaluation> Client::SubmitEvaluation(
    v1::InterpolateHeader header, const PolygonMesh& mesh,
    std::vector<SurfaceParameter> parameters) const {
  LIMN_ASSIGN_OR_RETURN(MeshUpload made, MeshUpload::Make(std::move(header), mesh, options_));
  const auto upload = std::make_shared<MeshUpload>(std::move(made));
  const auto send = [upload,
                     parameters = std::move(parameters)](ClientEvaluation::Impl::Stream& stream) {
    v1::EvaluateRequest request;
    const bool ok = upload->Send([&](v1::InterpolateRequest& part) {
      request.mutable_job()->Swap(&part);
      const bool written = stream.Write(request);
      request.mutable_job()->Swap(&part);
      return written;
    });
    if (!ok) return false;
    for (std::size_t begin = 0; begin < parameters.size(); begin += kBlock) {
      wire::WriteParameters(absl::MakeConstSpan(parameters).subspan(begin, kBlock),
                            request.mutable_parameters());
      if (!stream.Write(request)) return false;
    }
    return true;
  };
  return ClientEvaluation(std::make_unique<ClientEvaluation::Impl>(
      channel_, options_,
      [](v1::LimnService::Stub& stub, grpc::ClientContext* context) {
        return stub.Evaluate(context);
      },
      send));
}

absl::StatusOr<EvaluateResult> CollectEvaluation(ClientEvaluation* call, std::size_t parameters,
                                                 const Client::ProgressCallback& on_progress) {
  wire::SampleArrays samples;
  EvaluateResult result;
  bool has_summary = false;
  while (const std::optional<v1::EvaluateResponse> message = call->Next()) {
    if (message->has_progress()) {
      if (on_progress && !on_progress(message->progress())) call->Cancel();
    } else if (message->has_summary()) {
      result.summary = message->summary();
      has_summary = true;
    } else if (!message->has_accepted()) {
      LIMN_RETURN_IF_ERROR(wire::DecodeSamples(*message, &samples));
    }
  }
  LIMN_RETURN_IF_ERROR(call->Finish());
  if (!has_summary) return AnswerBrokeOff();
  if (samples.points.size() != parameters) return BadAnswer("samples are missing");
  result.points = std::move(samples.points);
  result.du = std::move(samples.du);
  result.dv = std::move(samples.dv);
  result.normals = std::move(samples.normals);
  return result;
}

absl::StatusOr<EvaluateResult> Client::Evaluate(const v1::InterpolateHeader& header,
                                                const PolygonMesh& mesh,
                                                const std::vector<SurfaceParameter>& parameters,
                                                const ProgressCallback& on_progress) const {
  bool stopped = false;
  const ProgressCallback watched = [&](const v1::Progress& progress) {
    stopped = stopped || (on_progress && !on_progress(progress));
    return !stopped;
  };
  Attempts attempts(options_, [&stopped] { return stopped; });
  while (true) {
    absl::StatusOr<ClientEvaluation> call =
        With(attempts.NextOptions()).SubmitEvaluation(header, mesh, parameters);
    if (!call.ok()) return call.status();
    absl::StatusOr<EvaluateResult> result = CollectEvaluation(&*call, parameters.size(), watched);
    if (result.ok() || stopped || !attempts.Again(result.status())) return result;
  }
}

}  // namespace limn
