// SPDX-License-Identifier: MIT
#include "server/stream_registry.h"

#include <vector>

namespace limn {

void StreamRegistry::Add(const std::shared_ptr<OpenStream>& stream) {
  const std::lock_guard lock(mutex_);
  streams_.emplace(stream.get(), stream);
}

void StreamRegistry::Remove(const OpenStream* stream) {
  const std::lock_guard lock(mutex_);
  streams_.erase(stream);
  if (streams_.empty()) empty_.notify_all();
}

bool StreamRegistry::WaitUntilEmpty(OpenStream::Clock::time_point until) {
  std::unique_lock lock(mutex_);
  return empty_.wait_until(lock, until, [this] { return streams_.empty(); });
}

void StreamRegistry::ForEach(const std::function<void(OpenStream&)>& visit) {
  std::vector<std::shared_ptr<OpenStream>> open;
  {
    const std::lock_guard lock(mutex_);
    open.reserve(streams_.size());
    for (const auto& [key, stream] : streams_) {
      if (std::shared_ptr<OpenStream> alive = stream.lock()) open.push_back(std::move(alive));
    }
  }
  for (const std::shared_ptr<OpenStream>& stream : open) visit(*stream);
}

std::size_t StreamRegistry::size() const {
  const std::lock_guard lock(mutex_);
  return streams_.size();
}

}  // namespace limn
