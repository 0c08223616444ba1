// SPDX-License-Identifier: MIT
// Runs the real binaries: limn to its end, limnd until it is stopped.
#include "tests/e2e/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <thread>

namespace limn::e2e {
namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kPoll{10};

// Opens a terminal. Returns our end; *name becomes the file that is the other end.
int OpenTerminal(std::string* name) {
  const int fd = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 || grantpt(fd) != 0 || unlockpt(fd) != 0) throw std::runtime_error("no terminal");
  *name = ptsname(fd);
  return fd;
}

// Makes a pipe with this name and fills it. Returns an end that keeps it from being closed.
int OpenFullPipe(const std::string& name) {
  if (mkfifo(name.c_str(), 0600) != 0) throw std::runtime_error("no pipe");
  const int fd = open(name.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) throw std::runtime_error("no pipe");
  const std::array<char, 4096> bytes{};
  while (write(fd, bytes.data(), bytes.size()) > 0) {
  }
  return fd;
}

// outputs: files of stdout and stderr.
pid_t Spawn(const std::vector<std::string>& command, const std::array<std::string, 2>& outputs) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const int flags = O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_NOCTTY;
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, outputs[0].c_str(), flags, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, outputs[1].c_str(), flags, 0600);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start " + command[0]);
  return pid;
}

std::vector<std::string> ServerCommand(const Workspace& workspace,
                                       const std::vector<std::string>& flags,
                                       const std::string& preload,
                                       const std::vector<std::string>& prefix) {
  std::filesystem::remove(workspace.log("port"));
  std::vector<std::string> command = prefix;
  if (!preload.empty()) command.insert(command.end(), {"/usr/bin/env", "LD_PRELOAD=" + preload});
  command.insert(command.end(), {LIMND_BINARY, "--listen", "127.0.0.1:0", "--port-file",
                                 workspace.log("port").string()});
  command.insert(command.end(), flags.begin(), flags.end());
  return command;
}

}  // namespace

Process::Process(const std::vector<std::string>& command, const std::filesystem::path& base,
                 Errors errors)
    : base_(base) {
  std::string errors_file = base.string() + ".err";
  if (errors == Errors::kTerminal) terminal_ = OpenTerminal(&errors_file);
  if (errors == Errors::kFullPipe) terminal_ = OpenFullPipe(errors_file);
  pid_ = Spawn(command, {base.string() + ".out", errors_file});
}

Process::~Process() {
  if (Running()) {
    Signal(SIGKILL);
    Reap(0);
  }
  if (terminal_ >= 0) close(terminal_);
}

void Process::Signal(int signal) const {
  if (!ended_) kill(pid_, signal);
}

bool Process::Reap(int flags) {
  if (ended_) return true;
  int status = 0;
  if (waitpid(pid_, &status, flags) != pid_) return false;
  ended_ = true;
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return true;
}

int Process::Wait(double timeout_seconds) {
  if (WaitUntil(timeout_seconds, [&] { return Reap(WNOHANG); })) return status_;
  Signal(SIGKILL);
  Reap(0);
  return kTimedOut;
}

bool Process::Running() { return !Reap(WNOHANG); }

std::string Process::Output() const { return ReadAll(base_.string() + ".out"); }

std::string Process::ErrorText() {
  if (terminal_ < 0) return ReadAll(base_.string() + ".err");
  if (!isatty(terminal_)) return "(nobody reads it)";
  std::array<char, 4096> buffer;
  // Ends with EAGAIN while the process runs and with EIO when it has ended.
  for (ssize_t got = 0; (got = read(terminal_, buffer.data(), buffer.size())) > 0;) {
    terminal_text_.append(buffer.data(), static_cast<std::size_t>(got));
  }
  return terminal_text_;
}

Workspace::Workspace() {
  std::string pattern = (std::filesystem::temp_directory_path() / "limn-e2e-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary directory");
  root_ = pattern;
  files_ = root_ / "files";
  logs_ = root_ / "logs";
  std::filesystem::create_directory(files_);
  std::filesystem::create_directory(logs_);
}

Workspace::~Workspace() {
  started_.clear();
  std::error_code ignored;
  std::filesystem::remove_all(root_, ignored);
}

RunResult Workspace::Limn(const std::vector<std::string>& arguments) const {
  std::vector<std::string> command = {LIMN_BINARY};
  command.insert(command.end(), arguments.begin(), arguments.end());
  Process process(command, logs_ / "limn");
  const int status = process.Wait();
  return {status, process.Output(), process.ErrorText()};
}

Process* Workspace::StartLimn(const std::vector<std::string>& arguments) {
  std::vector<std::string> command = {LIMN_BINARY};
  command.insert(command.end(), arguments.begin(), arguments.end());
  const std::string name = "limn-" + std::to_string(started_.size());
  started_.push_back(std::make_unique<Process>(command, logs_ / name, Process::Errors::kTerminal));
  return started_.back().get();
}

std::vector<std::string> Workspace::Files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(files_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

ServerProcess::ServerProcess(const Workspace& workspace, const std::vector<std::string>& flags,
                             Process::Errors errors, const std::string& preload,
                             const std::vector<std::string>& prefix)
    : process_(ServerCommand(workspace, flags, preload, prefix), workspace.log("limnd"), errors) {
  std::string port;
  WaitUntil(20, [&] {
    port = ReadAll(workspace.log("port"));
    return port.ends_with('\n') || !process_.Running();
  });
  if (port.empty()) throw std::runtime_error("limnd did not start:\n" + Log());
  port.pop_back();
  address_ = "127.0.0.1:" + port;
}

bool ServerProcess::WaitForLog(const std::string& text, double timeout_seconds) {
  return WaitUntil(timeout_seconds, [&] { return Log().find(text) != std::string::npos; });
}

bool WaitUntil(double timeout_seconds, const std::function<bool()>& condition) {
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_seconds);
  while (!condition()) {
    if (Clock::now() > end) return false;
    std::this_thread::sleep_for(kPoll);
  }
  return true;
}

std::string ReadAll(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void WriteAll(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary);
  out << bytes;
}

}  // namespace limn::e2e
