// SPDX-License-Identifier: MIT
// The boundary at which exceptions of the libraries below become errors.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <type_traits>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {

// Returns body(), an absl::Status or StatusOr, or the error that stands for what it threw.
template <class Body>
[[nodiscard]] auto Guarded(const Body& body) -> std::invoke_result_t<Body> {
  constexpr const char* kNoMemory = "the server has not enough memory for this job";
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return MakeError(kNoMemory, {.reason = Reason::kOutOfMemory});
  } catch (const std::length_error&) {
    return MakeError(kNoMemory, {.reason = Reason::kOutOfMemory});
  } catch (const std::exception& error) {
    return MakeError(absl::StrCat("unexpected: ", error.what()), {.reason = Reason::kInternal});
  }
}

}  // namespace limn
