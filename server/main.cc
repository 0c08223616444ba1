// SPDX-License-Identifier: MIT
// limnd: flags, start, signals, end.
#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "absl/cleanup/cleanup.h"
#include "engine/base/error.h"
#include "engine/base/heap.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/server.h"

namespace limn {
namespace {

constexpr int kExitUsage = 2;
constexpr int kExitFailure = 3;
// After drain-seconds, for a server that does not stop.
constexpr std::chrono::seconds kLastPatience(10);
// For the last lines of the log.
constexpr std::chrono::seconds kLogPatience(2);

struct Flags {
  ServerOptions server{.listen = "127.0.0.1:7410"};
  std::string port_file;
  std::string log_level = "info";
};

void AddFlags(CLI::App* app, Flags* flags) {
  app->set_version_flag("--version", std::string("limnd ") + LIMN_VERSION);
  app->add_option("--listen", flags->server.listen, "HOST:PORT to listen on; port 0 is a free one")
      ->capture_default_str();
  app->add_flag("--insecure", flags->server.insecure,
                "Allow --listen without --tls-cert, and --metrics-listen, on addresses that other "
                "machines can reach");
  app->add_option("--tls-cert", flags->server.tls.certificate,
                  "Certificate chain of the server, PEM; with it, only TLS is spoken. Read again "
                  "when it changes, as the other files here")
      ->type_name("FILE");
  app->add_option("--tls-key", flags->server.tls.key, "Its private key, PEM")->type_name("FILE");
  app->add_option("--tls-client-ca", flags->server.tls.client_authorities,
                  "Authorities that clients' certificates must come from, PEM; with it, every "
                  "client needs one")
      ->type_name("FILE");
  app->add_option("--token-file", flags->server.token_file,
                  "Bearer tokens, one of which every call needs, but for health and reflection: "
                  "lines of TOKEN or NAME TOKEN")
      ->type_name("FILE");
  app->add_option("--port-file", flags->port_file,
                  "File that the port is written to once the server serves");
  app->add_option("--metrics-listen", flags->server.metrics_listen,
                  "HOST:PORT to serve Prometheus metrics on, by http at /metrics; not encrypted")
      ->type_name("HOST:PORT");
  app->add_option("--threads", flags->server.threads,
                  "Threads that jobs are computed on; 0 is as many as there are processors, within "
                  "the CPU quota")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  app->add_option("--log-level", flags->log_level, "debug, info, warning, error or off")
      ->capture_default_str();
  for (const LimitEntry& entry : LimitTable()) {
    const std::string description =
        std::string(entry.description) + " (" + std::string(entry.unit) + ")";
    app->add_option("--" + std::string(entry.name), flags->server.limits.*entry.value, description)
        ->capture_default_str()
        ->group("Limits")
        ->check(CLI::Range(entry.least, entry.most));
  }
}

// What is wrong with the command line, in the form of limn's messages.
std::string UsageMessage(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<std::string> words = app.remaining();
  std::string message = error.what();
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError) && !words.empty()) {
    message =
        (words[0].starts_with('-') ? "there is no flag " : "there is an argument too many: ") +
        words[0];
  }
  return "limnd: " + message + "; see 'limnd --help'";
}

// Where libraries' lines go; null until there is a log, and again at its end.
std::atomic<Log*> library_log{nullptr};

// What libraries say, that of failed handshakes for instance, is lines of the log as all others,
// and not what clients can fill standard error with.
void TakeLibraryLog(gpr_log_func_args* line) {
  Log* const log = library_log.load();
  if (log == nullptr || line->severity < GPR_LOG_SEVERITY_ERROR) return;
  log->Debug(LogLine("grpc").Add("message", line->message));
}

// Whole or not at all: whoever waits for the file never reads half a number.
bool WritePortFile(const std::string& path, int port) {
  const std::string temporary = path + ".tmp" + std::to_string(getpid());
  std::ofstream file(temporary, std::ios::trunc);
  file << port << '\n';
  file.close();
  std::error_code error;
  if (file) std::filesystem::rename(temporary, path, error);
  if (file && !error) return true;
  std::filesystem::remove(temporary, error);
  return false;
}

// Every connection takes a descriptor, and when they run out the listener does not recover.
void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  (void)setrlimit(RLIMIT_NOFILE, &limit);
}

// Signals that end the server, blocked so that sigwait gets them. Threads take over what is blocked
// where they start, so this comes before the first of them: a thread that lets a signal through
// would have it end the process wherever the signal finds nobody waiting for it.
sigset_t BlockEndingSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  // A closed standard error or connection must not end the server.
  std::signal(SIGPIPE, SIG_IGN);
  return signals;
}

// Ends the process at a second signal, or when the shutdown takes longer than it may.
void WatchShutdown(sigset_t signals, std::chrono::seconds patience) {
  std::thread([signals, until = std::chrono::steady_clock::now() + patience] {
    constexpr timespec kTick{.tv_sec = 0, .tv_nsec = 100'000'000};
    int signal = -1;
    while (signal < 0 && std::chrono::steady_clock::now() < until) {
      signal = sigtimedwait(&signals, nullptr, &kTick);
    }
    std::_Exit(signal > 0 ? 128 + signal : kExitFailure);
  }).detach();
}

int Run(const Flags& flags, const sigset_t& signals) {
  absl::StatusOr<std::shared_ptr<Log>> log = Log::ToStderr(flags.log_level);
  if (!log.ok()) {
    std::cerr << "limnd: " << log.status().message() << "\n";
    return kExitUsage;
  }
  RaiseDescriptorLimit();
  library_log.store(log->get());
  const absl::Cleanup end_library_log = [] { library_log.store(nullptr); };
  gpr_set_log_function(TakeLibraryLog);
  // Strings that are no UTF-8 are refused; there is no more to say of them.
  google::protobuf::SetLogHandler(nullptr);

  ServerOptions options = flags.server;
  options.log = *log;
  absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  if (!server.ok()) {
    std::cerr << "limnd: " << server.status().message() << "\n";
    return server.status().code() == absl::StatusCode::kInvalidArgument ? kExitUsage : kExitFailure;
  }
  (*log)->Info(LogLine("listening")
                   .Add("address", options.listen)
                   .Add("port", static_cast<std::uint64_t>((*server)->port()))
                   .Add("metrics_port", static_cast<std::uint64_t>((*server)->metrics_port()))
                   .Add("threads", static_cast<std::uint64_t>((*server)->threads()))
                   .Add("version", LIMN_VERSION));
  if (!flags.port_file.empty() && !WritePortFile(flags.port_file, (*server)->port())) {
    const std::filesystem::path folder = std::filesystem::path(flags.port_file).parent_path();
    std::error_code error;
    const bool missing = !folder.empty() && !std::filesystem::exists(folder, error);
    std::cerr << "limnd: cannot write the port to " << flags.port_file
              << (missing ? ": the folder " + folder.string() + " does not exist" : "") << "\n";
    return kExitFailure;
  }

  int signal = 0;
  sigwait(&signals, &signal);
  const std::chrono::seconds patience(options.limits.drain_seconds);
  (*log)->Info(LogLine("stopping")
                   .Add("signal", static_cast<std::uint64_t>(signal))
                   .Add("drain_seconds", options.limits.drain_seconds));
  WatchShutdown(signals, patience + kLastPatience);
  const bool idle = (*server)->Shutdown(patience);
  (*log)->Info(LogLine("stopped").Add("work_left", idle ? "no" : "yes"));
  if (!idle) {
    // Every call has its answer; nobody waits for what is left.
    (void)(*log)->Flush(kLogPatience);
    std::_Exit(EXIT_SUCCESS);
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace limn

int main(int argc, char** argv) {
  const sigset_t signals = limn::BlockEndingSignals();
  limn::KeepHeap();
  CLI::App app("limnd serves interpolating subdivision surfaces by gRPC.", "limnd");
  limn::Flags flags;
  limn::AddFlags(&app, &flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::cerr << limn::UsageMessage(app, error) << "\n";
    return limn::kExitUsage;
  }
  return limn::Run(flags, signals);
}
