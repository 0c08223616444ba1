// SPDX-License-Identifier: MIT
// Runs the real binaries: limn to its end, limnd until it is stopped.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace limn::e2e {

// A process that writes its output into files.
class Process {
 public:
  // What stderr is. kFullPipe: a pipe that is full already and that nobody reads.
  enum class Errors { kFile, kTerminal, kFullPipe };

  // Starts `command` (program and arguments). stdout goes to the file BASE.out, which is emptied
  // first, stderr likewise to BASE.err, to a terminal of its own or to a pipe.
  Process(const std::vector<std::string>& command, const std::filesystem::path& base,
          Errors errors = Errors::kFile);
  // Kills what still runs.
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void Signal(int signal) const;
  // Exit status, or 128 + signal as shells count, or kTimedOut: then the process has been killed.
  int Wait(double timeout_seconds = 60);
  // Whether it has not ended yet.
  bool Running();
  pid_t pid() const { return pid_; }

  std::string Output() const;
  // What has been written to stderr so far.
  std::string ErrorText();

  static constexpr int kTimedOut = -1;

 private:
  bool Reap(int flags);

  std::filesystem::path base_;
  // The other end of the terminal or pipe, or -1.
  int terminal_ = -1;
  std::string terminal_text_;
  pid_t pid_ = -1;
  bool ended_ = false;
  int status_ = 0;
};

struct RunResult {
  int status = 0;
  std::string output;
  std::string errors;
};

// A directory of its own for each test, removed at the end, with the binaries at hand.
class Workspace {
 public:
  Workspace();
  ~Workspace();
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  std::filesystem::path path(const std::string& name) const { return files_ / name; }
  // Runs `limn` with these arguments to its end.
  RunResult Limn(const std::vector<std::string>& arguments) const;
  // Starts it, with a terminal as stderr.
  Process* StartLimn(const std::vector<std::string>& arguments);
  // Names of all files that the tests' commands made, sorted.
  std::vector<std::string> Files() const;
  // Where the outputs of processes are kept.
  std::filesystem::path log(const std::string& name) const { return logs_ / name; }

 private:
  std::filesystem::path root_;
  std::filesystem::path files_;
  std::filesystem::path logs_;
  std::vector<std::unique_ptr<Process>> started_;
};

// limnd on a free loopback port.
class ServerProcess {
 public:
  // flags: beside --listen and --port-file. preload: a library that stands in for parts of others,
  // or nothing. prefix: a command that runs the one behind it, such as prlimit. Throws
  // std::runtime_error when it does not come up.
  explicit ServerProcess(const Workspace& workspace, const std::vector<std::string>& flags = {},
                         Process::Errors errors = Process::Errors::kFile,
                         const std::string& preload = "",
                         const std::vector<std::string>& prefix = {});

  const std::string& address() const { return address_; }
  // Everything that it has printed.
  std::string Log() { return process_.Output() + process_.ErrorText(); }
  // Waits until its log contains `text`.
  bool WaitForLog(const std::string& text, double timeout_seconds = 20);
  Process& process() { return process_; }

 private:
  Process process_;
  std::string address_;
};

// Polls until `condition` holds; whether it did in time.
bool WaitUntil(double timeout_seconds, const std::function<bool()>& condition);

std::string ReadAll(const std::filesystem::path& path);
void WriteAll(const std::filesystem::path& path, const std::string& bytes);

}  // namespace limn::e2e
