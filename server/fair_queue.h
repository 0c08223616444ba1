// SPDX-License-Identifier: MIT
// In which order waiting jobs of several clients run: deficit round robin (Shreedhar and Varghese,
// "Efficient fair queueing using deficit round robin", 1995) with ageing.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <list>
#include <optional>
#include <string>

namespace limn {

// Every client with waiting jobs gets the same share of the work that is done, whatever the number
// and size of its jobs; jobs of one client keep their order. A job's cost falls with the time that
// it has waited, to nothing at `patience`; from then on it goes before all others, the longest
// waiting first. So no job waits for ever behind others' cheap ones. Not thread-safe.
class FairQueue {
 public:
  using Clock = std::chrono::steady_clock;
  using Id = std::uint64_t;

  explicit FairQueue(Clock::duration patience) : patience_(patience) {}

  // cost: in any unit; 0 counts as 1. Cost: linear in the number of clients.
  void Push(Id id, const std::string& client, std::uint64_t cost, Clock::time_point now);
  // Takes the next job out; nothing when there is none. Cost: linear in the number of clients.
  std::optional<Id> Pop(Clock::time_point now);
  // False: it is not there. Cost: linear in the number of jobs.
  bool Remove(Id id);

  bool empty() const { return clients_.empty(); }

 private:
  struct Job {
    Id id;
    std::uint64_t cost;
    Clock::time_point arrived;
  };
  // A client with waiting jobs.
  struct Client {
    std::string name;
    // Work that it may have done before the others' turn comes.
    double deficit = 0;
    std::deque<Job> jobs;
  };
  using Clients = std::list<Client>;

  double CostOf(const Job& job, Clock::time_point now) const;
  Clients::iterator LongestWaiting(Clock::time_point now);
  Id Take(Clients::iterator client, double cost);

  const Clock::duration patience_;
  // In the order of their turns.
  Clients clients_;
};

}  // namespace limn
