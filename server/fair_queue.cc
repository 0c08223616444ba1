// SPDX-License-Identifier: MIT
#include "server/fair_queue.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace limn {

void FairQueue::Push(Id id, const std::string& client, std::uint64_t cost, Clock::time_point now) {
  auto at = std::find_if(clients_.begin(), clients_.end(),
                         [&](const Client& other) { return other.name == client; });
  if (at == clients_.end()) {
    clients_.push_back({.name = client});
    at = std::prev(clients_.end());
  }
  at->jobs.push_back({id, std::max<std::uint64_t>(1, cost), now});
}

double FairQueue::CostOf(const Job& job, Clock::time_point now) const {
  const double waited = std::chrono::duration<double>(now - job.arrived).count();
  const double patience = std::chrono::duration<double>(patience_).count();
  return static_cast<double>(job.cost) * std::max(0.0, 1 - waited / patience);
}

FairQueue::Clients::iterator FairQueue::LongestWaiting(Clock::time_point now) {
  auto found = clients_.end();
  for (auto client = clients_.begin(); client != clients_.end(); ++client) {
    const Clock::time_point arrived = client->jobs.front().arrived;
    if (now - arrived < patience_) continue;
    if (found == clients_.end() || arrived < found->jobs.front().arrived) found = client;
  }
  return found;
}

FairQueue::Id FairQueue::Take(Clients::iterator client, double cost) {
  const Id id = client->jobs.front().id;
  client->jobs.pop_front();
  client->deficit -= cost;
  // A client without jobs leaves, and its deficit with it: who is not there saves nothing up.
  if (client->jobs.empty()) clients_.erase(client);
  return id;
}

// The textbook's quantum is added to every client on each round. Rounds in which nobody can be
// served are taken at once: the one whose turn comes first is who needs the least.
std::optional<FairQueue::Id> FairQueue::Pop(Clock::time_point now) {
  if (clients_.empty()) return std::nullopt;
  if (const auto waiting = LongestWaiting(now); waiting != clients_.end()) return Take(waiting, 0);
  auto next = clients_.end();
  double least = std::numeric_limits<double>::infinity();
  for (auto client = clients_.begin(); client != clients_.end(); ++client) {
    const double missing = std::max(0.0, CostOf(client->jobs.front(), now) - client->deficit);
    if (missing >= least) continue;
    least = missing;
    next = client;
  }
  for (Client& client : clients_) client.deficit += least;
  const double cost = CostOf(next->jobs.front(), now);
  // Its turn is over: among equals the others come first.
  clients_.splice(clients_.end(), clients_, next);
  return Take(next, cost);
}

bool FairQueue::Remove(Id id) {
  for (auto client = clients_.begin(); client != clients_.end(); ++client) {
    const auto job = std::find_if(client->jobs.begin(), client->jobs.end(),
                                  [id](const Job& other) { return other.id == id; });
    if (job == client->jobs.end()) continue;
    client->jobs.erase(job);
    if (client->jobs.empty()) clients_.erase(client);
    return true;
  }
  return false;
}

}  // namespace limn
