// SPDX-License-Identifier: MIT
// Exceptions of libraries and of the allocator end here and become errors.
#pragma once

#include <exception>
#include <new>
#include <stdexcept>
#include <string_view>

#include "absl/strings/str_cat.h"
#include "engine/base/error.h"

namespace limn {

// f() (an absl::Status or absl::StatusOr), or OUT_OF_MEMORY when memory ran out, or `otherwise`
// for any other exception. what: the work, for the message, such as "decoding the mesh".
template <class F>
auto Guarded(const char* what, Reason otherwise, F&& f) -> decltype(f()) {
  const auto out_of_memory = [&] {
    return MakeError(absl::StrCat("memory ran out while ", what),
                     {.reason = Reason::kOutOfMemory, .remedy = "Try again later or with less"});
  };
  try {
    return f();
  } catch (const std::bad_alloc&) {
    return out_of_memory();
  } catch (const std::length_error&) {
    return out_of_memory();
  } catch (const std::exception& e) {
    return MakeError(absl::StrCat("failed while ", what, ": ", e.what()), {.reason = otherwise});
  }
}

}  // namespace limn
