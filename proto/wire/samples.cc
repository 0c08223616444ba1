// SPDX-License-Identifier: MIT
#include "proto/wire/samples.h"

#include <bit>
#include <cstring>
#include <string>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn::wire {
namespace {

// Arrays travel as they lie in memory.
static_assert(std::endian::native == std::endian::little);
static_assert(sizeof(Vec3) == 24);

void Encode(const std::vector<Vec3>& vectors, std::string* bytes) {
  bytes->assign(reinterpret_cast<const char*>(vectors.data()), vectors.size() * sizeof(Vec3));
}

void Append(const std::string& bytes, std::vector<Vec3>* vectors) {
  const std::size_t before = vectors->size();
  vectors->resize(before + bytes.size() / sizeof(Vec3));
  if (!bytes.empty()) std::memcpy(vectors->data() + before, bytes.data(), bytes.size());
}

absl::Status Unequal(const char* field, int size, int expected) {
  return MakeError(absl::StrCat("the block has ", expected, " faces, but ", size, " ", field),
                   {.reason = Reason::kMalformedRequest,
                    .field = absl::StrCat("parameters.", field),
                    .remedy = "Send four arrays of the same length"});
}

absl::Status BadSamples(std::uint64_t first) {
  return MakeError(absl::StrCat("the samples from number ", first, " on do not make sense"),
                   {.reason = Reason::kMalformedEncoding,
                    .field = "first",
                    .remedy = "Is this a server of another version?"});
}

}  // namespace

absl::Status CheckParameterArrays(const v1::ParameterBlock& block) {
  const int n = block.faces_size();
  if (block.corners_size() != n) return Unequal("corners", block.corners_size(), n);
  if (block.u_size() != n) return Unequal("u", block.u_size(), n);
  if (block.v_size() != n) return Unequal("v", block.v_size(), n);
  return absl::OkStatus();
}

absl::Status CheckParameters(const v1::ParameterBlock& block) {
  LIMN_RETURN_IF_ERROR(CheckParameterArrays(block));
  const int n = block.faces_size();
  if (static_cast<std::size_t>(n) <= kMaxBlockParameters) return absl::OkStatus();
  return MakeError(absl::StrCat("the block has ", n, " parameters"),
                   {.reason = Reason::kMalformedRequest,
                    .field = "parameters",
                    .remedy = absl::StrCat("Send blocks of at most ", kMaxBlockParameters)});
}

std::vector<SurfaceParameter> ReadParameters(const v1::ParameterBlock& block, std::size_t begin,
                                             std::size_t count) {
  std::vector<SurfaceParameter> parameters(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int at = static_cast<int>(begin + i);
    parameters[i] = {block.faces(at), block.corners(at), block.u(at), block.v(at)};
  }
  return parameters;
}

void WriteParameters(absl::Span<const SurfaceParameter> parameters, v1::ParameterBlock* block) {
  block->Clear();
  const int n = static_cast<int>(parameters.size());
  block->mutable_faces()->Reserve(n);
  block->mutable_corners()->Reserve(n);
  block->mutable_u()->Reserve(n);
  block->mutable_v()->Reserve(n);
  for (const SurfaceParameter& p : parameters) {
    block->add_faces(p.face);
    block->add_corners(p.corner);
    block->add_u(p.u);
    block->add_v(p.v);
  }
}

void SampleArrays::Resize(std::size_t n) {
  points.resize(n);
  du.resize(n);
  dv.resize(n);
  normals.resize(n);
}

SurfaceSamples SampleArrays::Spans() {
  return {.points = absl::MakeSpan(points),
          .du = absl::MakeSpan(du),
          .dv = absl::MakeSpan(dv),
          .normals = absl::MakeSpan(normals)};
}

void EncodeSamples(const SampleArrays& samples, std::uint64_t first,
                   v1::EvaluateResponse* message) {
  message->set_first(first);
  Encode(samples.points, message->mutable_positions());
  Encode(samples.du, message->mutable_derivatives_u());
  Encode(samples.dv, message->mutable_derivatives_v());
  Encode(samples.normals, message->mutable_normals());
}

absl::Status DecodeSamples(const v1::EvaluateResponse& message, SampleArrays* samples) {
  const std::size_t bytes = message.positions().size();
  if (message.first() != samples->points.size() || bytes % sizeof(Vec3) != 0 ||
      message.derivatives_u().size() != bytes || message.derivatives_v().size() != bytes ||
      message.normals().size() != bytes) {
    return BadSamples(message.first());
  }
  Append(message.positions(), &samples->points);
  Append(message.derivatives_u(), &samples->du);
  Append(message.derivatives_v(), &samples->dv);
  Append(message.normals(), &samples->normals);
  return absl::OkStatus();
}

}  // namespace limn::wire
