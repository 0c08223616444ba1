// SPDX-License-Identifier: MIT
// The ways to name servers.
#include "client/servers.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "engine/base/error.h"

namespace limn {
namespace {

using Hosts = std::vector<std::string>;

TEST(ServersTest, OneServerIsLookedUpByName) {
  for (const std::string text : {"limn.example:7410", "dns:///limn.example:7410"}) {
    const absl::StatusOr<ServerAddresses> servers = ParseServers(text);
    ASSERT_TRUE(servers.ok()) << servers.status();
    EXPECT_EQ(servers->target, "dns:///limn.example:7410");
    EXPECT_EQ(servers->first, "limn.example:7410");
    EXPECT_EQ(servers->hosts, Hosts{"limn.example"});
  }
}

TEST(ServersTest, ANumericServerIsOneToo) {
  EXPECT_EQ(ParseServers("127.0.0.1:7410")->target, "dns:///127.0.0.1:7410");
  EXPECT_EQ(ParseServers("ipv4:127.0.0.1:7410")->target, "dns:///127.0.0.1:7410");
  EXPECT_EQ(ParseServers("[::1]:7410")->target, "dns:///[::1]:7410");
  EXPECT_EQ(ParseServers("[::1]:7410")->hosts, Hosts{"::1"});
}

TEST(ServersTest, AListKeepsItsFirstAndComesInAnyOrder) {
  std::set<std::string> targets;
  for (int round = 0; round < 100; ++round) {
    const absl::StatusOr<ServerAddresses> servers = ParseServers("10.0.0.1:1,10.0.0.2:2");
    ASSERT_TRUE(servers.ok()) << servers.status();
    EXPECT_EQ(servers->first, "10.0.0.1:1");
    EXPECT_EQ(servers->hosts, (Hosts{"10.0.0.1", "10.0.0.2"}));
    targets.insert(servers->target);
  }
  EXPECT_EQ(targets,
            (std::set<std::string>{"ipv4:10.0.0.1:1,10.0.0.2:2", "ipv4:10.0.0.2:2,10.0.0.1:1"}));
}

TEST(ServersTest, AListOfTheSixthVersionHasBrackets) {
  const absl::StatusOr<ServerAddresses> servers = ParseServers("ipv6:[::1]:1,[::2]:2");
  ASSERT_TRUE(servers.ok()) << servers.status();
  EXPECT_TRUE(servers->target.starts_with("ipv6:[")) << servers->target;
  EXPECT_EQ(servers->hosts, (Hosts{"::1", "::2"}));
}

TEST(ServersTest, OneNumericAddressIsOneServerAndANameMayBeMany) {
  for (const std::string text : {"127.0.0.1:1", "[::1]:1", "localhost:1", "ipv4:10.0.0.1:1"}) {
    EXPECT_TRUE(IsOneServer(*ParseServers(text))) << text;
  }
  for (const std::string text : {"limn.example:1", "127.0.0.1:1,127.0.0.1:2"}) {
    EXPECT_FALSE(IsOneServer(*ParseServers(text))) << text;
  }
}

TEST(ServersTest, WhatIsNoAddressIsRefused) {
  for (const std::string text :
       {"", "limn", ":7410", "limn:", "limn:0", "limn:65536", "limn:x", "127.0.0.1:1,",
        ",127.0.0.1:1", "limn:1,limn:2", "127.0.0.1:1,limn:2", "127.0.0.1:1,[::1]:2", "::1:7410"}) {
    const absl::StatusOr<ServerAddresses> servers = ParseServers(text);
    ASSERT_FALSE(servers.ok()) << text;
    const std::optional<ErrorDetail> detail = GetErrorDetail(servers.status());
    EXPECT_EQ(detail->reason, Reason::kInvalidOption) << text;
    EXPECT_EQ(detail->field, "server") << text;
  }
}

}  // namespace
}  // namespace limn
