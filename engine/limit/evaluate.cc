// SPDX-License-Identifier: MIT
#include "engine/limit/evaluate.h"

#include <atomic>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"
#include "engine/base/parallel.h"
#include "engine/limit/patch_source.h"

namespace limn {
namespace {

// Parameters per chunk, some hundred microseconds of work.
constexpr std::size_t kGrain = 256;

bool InUnitInterval(double t) { return t >= 0 && t <= 1; }

// Whether u and v lie in a triangle. As rounded, so that pairs like 0.1 and 0.9 do.
bool InTriangle(double u, double v) { return u + v <= 1; }

bool IsValid(const PatchSource& source, const SurfaceParameter& p) {
  return p.face < source.face_count() && p.corner < source.arity(p.face) && InUnitInterval(p.u) &&
         InUnitInterval(p.v) && (!source.triangles() || InTriangle(p.u, p.v));
}

// What is wrong with parameter number i.
absl::Status Refusal(const PatchSource& source, const SurfaceParameter& p, std::uint64_t i) {
  const auto error = [&](Reason reason, const char* field, const std::string& value,
                         const std::string& range) {
    const std::string path = absl::StrCat("parameters[", i, "].", field);
    return MakeError(absl::StrCat(path, " is ", value),
                     {.reason = reason,
                      .field = path,
                      .index = i,
                      .remedy = absl::StrCat("It must be from 0 to ", range)});
  };
  if (p.face >= source.face_count()) {
    return error(Reason::kIndexOutOfRange, "face", absl::StrCat(p.face),
                 absl::StrCat(source.face_count() - 1));
  }
  if (p.corner >= source.arity(p.face)) {
    return error(Reason::kIndexOutOfRange, "corner", absl::StrCat(p.corner),
                 absl::StrCat(source.arity(p.face) - 1, " in face ", p.face));
  }
  if (!InUnitInterval(p.u)) return error(Reason::kInvalidOption, "u", absl::StrCat(p.u), "1");
  if (!InUnitInterval(p.v)) return error(Reason::kInvalidOption, "v", absl::StrCat(p.v), "1");
  return error(Reason::kInvalidOption, "v", absl::StrCat(p.v, " where u is ", p.u),
               "1 - u in a triangle");
}

// The first invalid parameter of begin .. end - 1, or end.
std::size_t FirstInvalid(const PatchSource& source, absl::Span<const SurfaceParameter> parameters,
                         std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    if (!IsValid(source, parameters[i])) return i;
  }
  return end;
}

}  // namespace

SurfaceEvaluator::SurfaceEvaluator(std::unique_ptr<const PatchSource> source)
    : source_(std::move(source)) {}
SurfaceEvaluator::SurfaceEvaluator(SurfaceEvaluator&&) noexcept = default;
SurfaceEvaluator& SurfaceEvaluator::operator=(SurfaceEvaluator&&) noexcept = default;
SurfaceEvaluator::~SurfaceEvaluator() = default;

absl::StatusOr<SurfaceEvaluator> SurfaceEvaluator::Create(const Context& context,
                                                          const DooSabinSurface& surface) {
  LIMN_ASSIGN_OR_RETURN(std::unique_ptr<PatchSource> source, MakeDooSabinPatches(context, surface));
  return SurfaceEvaluator(std::move(source));
}

absl::StatusOr<SurfaceEvaluator> SurfaceEvaluator::Create(const Context& context,
                                                          const PrimalSurface& surface) {
  LIMN_RETURN_IF_ERROR(context.Check());
  return SurfaceEvaluator(MakePrimalPatches(surface));
}

absl::StatusOr<SurfaceEvaluator> SurfaceEvaluator::Create(const Context& context,
                                                          const LimitSurface& surface) {
  return std::visit([&](const auto& s) { return Create(context, s); }, surface);
}

absl::Status SurfaceEvaluator::Evaluate(const Context& context,
                                        absl::Span<const SurfaceParameter> parameters,
                                        const SurfaceSamples& samples, std::uint64_t first) const {
  // The smallest of all that are found, whatever their order.
  std::atomic<std::size_t> wrong = parameters.size();
  LIMN_RETURN_IF_ERROR(
      ParallelFor(context, parameters.size(), kGrain, [&](std::size_t begin, std::size_t end) {
        const std::size_t found = FirstInvalid(*source_, parameters, begin, end);
        source_->Evaluate(context, parameters, samples, {begin, found});
        if (found == end) return;
        std::size_t known = wrong.load();
        while (found < known && !wrong.compare_exchange_weak(known, found)) {
        }
      }));
  const std::size_t i = wrong.load();
  if (i == parameters.size()) return absl::OkStatus();
  return Refusal(*source_, parameters[i], first + i);
}

}  // namespace limn
