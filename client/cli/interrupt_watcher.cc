// SPDX-License-Identifier: MIT
// Turns SIGINT (Ctrl-C) and SIGTERM into a call on an ordinary thread.
#include "client/cli/interrupt_watcher.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace limn::cli {
namespace {

constexpr char kSignal = 's';
constexpr char kQuit = 'q';

// Write end of the watcher's pipe; the only thing that the handler touches.
std::atomic<int> g_pipe_end{-1};
static_assert(std::atomic<int>::is_always_lock_free);

extern "C" void OnSignal(int /*signal*/) {
  const int saved_errno = errno;
  // A full pipe means that a byte is waiting already.
  (void)!write(g_pipe_end.load(), &kSignal, 1);
  errno = saved_errno;
}

}  // namespace

InterruptWatcher::InterruptWatcher(std::function<void()> on_interrupt)
    : on_interrupt_(std::move(on_interrupt)) {
  // Without a pipe there is nothing to watch: signals keep ending the process.
  if (pipe2(pipe_.data(), O_CLOEXEC) != 0) return;
  g_pipe_end.store(pipe_[1]);
  thread_ = std::thread([this] { Watch(); });

  struct sigaction action = {};
  action.sa_handler = OnSignal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = static_cast<int>(SA_RESTART | SA_RESETHAND);
  sigaction(SIGINT, &action, &old_int_);
  sigaction(SIGTERM, &action, &old_term_);
}

InterruptWatcher::~InterruptWatcher() {
  if (!thread_.joinable()) return;
  sigaction(SIGINT, &old_int_, nullptr);
  sigaction(SIGTERM, &old_term_, nullptr);
  (void)!write(pipe_[1], &kQuit, 1);
  thread_.join();
  g_pipe_end.store(-1);
  close(pipe_[0]);
  close(pipe_[1]);
}

void InterruptWatcher::Watch() {
  for (;;) {
    char byte = kQuit;
    const ssize_t got = read(pipe_[0], &byte, 1);
    if (got < 0 && errno == EINTR) continue;
    if (got != 1 || byte == kQuit) return;
    if (!interrupted_.exchange(true)) on_interrupt_();
  }
}

}  // namespace limn::cli
