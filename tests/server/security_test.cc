// SPDX-License-Identifier: MIT
// Who may call: TLS, certificates of clients, tokens; and that nothing else may.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <thread>

#include "server/tokens.h"
#include "tests/server/certificates.h"
#include "tests/server/service_fixture.h"

namespace limn {
namespace {

constexpr char kToken[] = "0123456789abcdefABCDEF";
constexpr char kOtherToken[] = "another-token-of-some-length";

class SecurityTest : public testing::Test {
 protected:
  // A server that speaks TLS.
  ServerOptions TlsOptions() {
    const TestIdentity identity = authority_.Issue("limnd");
    ServerOptions options{.listen = "127.0.0.1:0", .threads = 1};
    options.tls.certificate = files_.Write("server.pem", identity.certificate);
    options.tls.key = files_.Write("server.key", identity.key);
    return options;
  }
  ServerOptions MutualOptions() {
    ServerOptions options = TlsOptions();
    options.tls.client_authorities = files_.Write("clients.pem", authority_.certificate());
    return options;
  }
  // A client that trusts the authority.
  ClientSecurity Trusting(const TestAuthority& authority) const {
    return {.ca_file = files_.Write("ca.pem", authority.certificate())};
  }
  ClientSecurity WithIdentity(const TestIdentity& identity) const {
    ClientSecurity security = Trusting(authority_);
    security.certificate_file = files_.Write("client.pem", identity.certificate);
    security.key_file = files_.Write("client.key", identity.key);
    return security;
  }
  static absl::Status Call(const Server& server, const ClientSecurity& security) {
    const absl::StatusOr<Client> client = Client::ConnectSecurely(
        "127.0.0.1:" + std::to_string(server.port()), security, {.deadline_seconds = 10});
    return client.ok() ? client->GetServerInfo().status() : client.status();
  }
  // Whole jobs take the same way.
  static absl::Status RunJob(const Server& server, const ClientSecurity& security) {
    const absl::StatusOr<Client> client = Client::ConnectSecurely(
        "127.0.0.1:" + std::to_string(server.port()), security, {.deadline_seconds = 30});
    return client.ok() ? client->Run(MakeHeader(1), MakeSphere(100)).status() : client.status();
  }

  TestDirectory files_;
  TestAuthority authority_{"Limn's authority"};
  TestAuthority other_authority_{"Somebody's authority"};
};

TEST_F(SecurityTest, ATrustingClientRunsJobsOverTls) {
  const std::unique_ptr<Server> server = StartServer(TlsOptions());
  EXPECT_TRUE(RunJob(*server, Trusting(authority_)).ok());
}

TEST_F(SecurityTest, AServerOfAnotherAuthorityIsNotTrusted) {
  const std::unique_ptr<Server> server = StartServer(TlsOptions());
  EXPECT_EQ(Call(*server, Trusting(other_authority_)).code(), absl::StatusCode::kUnavailable);
}

TEST_F(SecurityTest, PlaintextToTlsIsNoCall) {
  const std::unique_ptr<Server> server = StartServer(TlsOptions());
  EXPECT_EQ(Call(*server, {}).code(), absl::StatusCode::kUnavailable);
}

TEST_F(SecurityTest, TlsToPlaintextIsNoCall) {
  const std::unique_ptr<Server> server = StartServer({.listen = "127.0.0.1:0", .threads = 1});
  EXPECT_EQ(Call(*server, Trusting(authority_)).code(), absl::StatusCode::kUnavailable);
}

TEST_F(SecurityTest, MutualTlsTakesCertificatesOfItsAuthorityOnly) {
  const std::unique_ptr<Server> server = StartServer(MutualOptions());
  EXPECT_TRUE(RunJob(*server, WithIdentity(authority_.Issue("client"))).ok());
  EXPECT_EQ(Call(*server, Trusting(authority_)).code(), absl::StatusCode::kUnavailable)
      << "without a certificate";
  EXPECT_EQ(Call(*server, WithIdentity(other_authority_.Issue("client"))).code(),
            absl::StatusCode::kUnavailable)
      << "of another authority";
  EXPECT_EQ(Call(*server, WithIdentity(authority_.Issue("client", -60))).code(),
            absl::StatusCode::kUnavailable)
      << "expired";
}

TEST_F(SecurityTest, AnExpiredServerIsNotTrusted) {
  // limnd does not start with such a certificate, but it may run until one expires.
  const TestIdentity identity = authority_.Issue("limnd", 2);
  ServerOptions options = TlsOptions();
  options.tls.certificate = files_.Write("server.pem", identity.certificate);
  options.tls.key = files_.Write("server.key", identity.key);
  const std::unique_ptr<Server> server = StartServer(options);
  EXPECT_TRUE(Call(*server, Trusting(authority_)).ok());
  std::this_thread::sleep_for(std::chrono::milliseconds(3200));
  EXPECT_EQ(Call(*server, Trusting(authority_)).code(), absl::StatusCode::kUnavailable);
}

TEST_F(SecurityTest, CertificatesAreReadAgainWithoutARestart) {
  const std::unique_ptr<Server> server = StartServer(TlsOptions());
  EXPECT_TRUE(Call(*server, Trusting(authority_)).ok());
  // A long call goes on across the change.
  const absl::StatusOr<Client> client = Client::ConnectSecurely(
      "127.0.0.1:" + std::to_string(server->port()), Trusting(authority_), {});
  ASSERT_TRUE(client.ok());
  absl::StatusOr<ClientJob> job = client->Submit(MakeEndlessHeader(), MakeSphere(5000));
  ASSERT_TRUE(job.ok());
  ASSERT_TRUE(job->Next().has_value());

  const TestIdentity renewed = other_authority_.Issue("limnd");
  files_.Write("server.key", renewed.key);
  files_.Write("server.pem", renewed.certificate);
  bool taken = false;
  for (int attempt = 0; attempt < 100 && !taken; ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    taken = Call(*server, Trusting(other_authority_)).ok();
  }
  EXPECT_TRUE(taken);
  EXPECT_EQ(Call(*server, Trusting(authority_)).code(), absl::StatusCode::kUnavailable);
  EXPECT_TRUE(job->Next().has_value());
  job->Cancel();
}

TEST_F(SecurityTest, FilesThatDoNotFitTogetherDoNotReplaceThoseThatDo) {
  const EventLog events;
  ServerOptions options = TlsOptions();
  options.log = events.log();
  const std::unique_ptr<Server> server = StartServer(options);
  EXPECT_TRUE(Call(*server, Trusting(authority_)).ok());
  // A renewal whose key has not come yet.
  const TestIdentity renewed = other_authority_.Issue("limnd");
  files_.Write("server.pem", renewed.certificate);
  EXPECT_NE(events.WaitFor("event=certificates_not_read"), "");
  // gRPC looks once a second.
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  EXPECT_TRUE(Call(*server, Trusting(authority_)).ok());
  files_.Write("server.key", renewed.key);
  EXPECT_NE(events.WaitFor("event=certificates_read"), "");
  bool taken = false;
  for (int attempt = 0; attempt < 100 && !taken; ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    taken = Call(*server, Trusting(other_authority_)).ok();
  }
  EXPECT_TRUE(taken);
}

struct BadFlags {
  std::string name;
  std::string field;
  std::function<void(ServerOptions&, const TestDirectory&)> spoil;
};
void PrintTo(const BadFlags& c, std::ostream* out) { *out << c.name; }

class BadSecurityTest : public SecurityTest, public testing::WithParamInterface<BadFlags> {};

TEST_P(BadSecurityTest, IsRefusedAtTheStartByName) {
  ServerOptions options = MutualOptions();
  GetParam().spoil(options, files_);
  const absl::Status status = Server::Start(options).status();
  EXPECT_EQ(ReasonOf(status), Reason::kInvalidOption) << status;
  EXPECT_EQ(GetErrorDetail(status)->field, GetParam().field) << status;
}

INSTANTIATE_TEST_SUITE_P(
    Flags, BadSecurityTest,
    testing::Values(
        BadFlags{"NoKey", "tls-key", [](auto& o, auto&) { o.tls.key.clear(); }},
        BadFlags{"KeyAlone", "tls-key", [](auto& o, auto&) { o.tls.certificate.clear(); }},
        BadFlags{"ClientsOnly", "tls-client-ca",
                 [](auto& o, auto&) {
                   o.tls.certificate.clear();
                   o.tls.key.clear();
                 }},
        BadFlags{"OtherKey", "tls-key",
                 [](auto& o, auto& f) {
                   o.tls.key = f.Write("o.key", TestAuthority("x").Issue("y").key);
                 }},
        BadFlags{"Expired", "tls-cert",
                 [](auto& o, auto& f) {
                   const TestIdentity identity = TestAuthority("x").Issue("y", -60);
                   o.tls.certificate = f.Write("e.pem", identity.certificate);
                   o.tls.key = f.Write("e.key", identity.key);
                 }},
        BadFlags{"CertificateIsNone", "tls-cert",
                 [](auto& o, auto& f) { o.tls.certificate = f.Write("n.pem", "nothing"); }},
        BadFlags{"CertificateIsNotThere", "tls-cert",
                 [](auto& o, auto& f) { o.tls.certificate = f.path("nowhere"); }},
        BadFlags{"AuthoritiesAreNotThere", "tls-client-ca",
                 [](auto& o, auto& f) { o.tls.client_authorities = f.path("nowhere"); }},
        BadFlags{"TokensAreNotThere", "token-file",
                 [](auto& o, auto& f) { o.token_file = f.path("nowhere"); }},
        BadFlags{"NoTokens", "token-file",
                 [](auto& o, auto& f) { o.token_file = f.Write("t", "# none\n\n"); }},
        BadFlags{"ShortToken", "token-file",
                 [](auto& o, auto& f) { o.token_file = f.Write("t", "name short\n"); }},
        BadFlags{"ThreeWords", "token-file",
                 [](auto& o, auto& f) {
                   o.token_file = f.Write("t", std::string("a b ") + kToken + "\n");
                 }}),
    [](const auto& test) { return test.param.name; });

TEST_F(SecurityTest, OtherMachinesNeedTlsOrTheWordInsecure) {
  ServerOptions options{.listen = "0.0.0.0:0", .threads = 1};
  EXPECT_EQ(ReasonOf(Server::Start(options).status()), Reason::kInvalidOption);
  options.insecure = true;
  EXPECT_TRUE(Server::Start(options).ok());
  options = TlsOptions();
  options.listen = "0.0.0.0:0";
  EXPECT_TRUE(Server::Start(options).ok());
}

TEST_F(SecurityTest, EveryRpcNeedsAToken) {
  ServerOptions options{.listen = "127.0.0.1:0", .threads = 1};
  options.token_file = files_.Write("tokens", std::string("# ours\nalice ") + kToken + "\n");
  const std::unique_ptr<Server> server = StartServer(options);
  const auto channel = grpc::CreateChannel("127.0.0.1:" + std::to_string(server->port()),
                                           grpc::InsecureChannelCredentials());
  const google::protobuf::ServiceDescriptor* const service =
      v1::InterpolateRequest::descriptor()->file()->pool()->FindServiceByName(
          v1::LimnService::service_full_name());
  ASSERT_NE(service, nullptr);
  ASSERT_GE(service->method_count(), 5);
  for (int i = 0; i < service->method_count(); ++i) {
    const RawAnswer answer =
        CallRaw(channel, "/limn.v1.LimnService/" + service->method(i)->name(), "");
    EXPECT_EQ(answer.status.error_code(), grpc::StatusCode::UNAUTHENTICATED)
        << service->method(i)->name();
    EXPECT_EQ(answer.bytes, "") << service->method(i)->name();
    v1::RichStatus rich;
    ASSERT_TRUE(rich.ParseFromString(answer.status.error_details()));
    EXPECT_EQ(ErrorInfoOf(rich).reason(), "UNAUTHENTICATED") << service->method(i)->name();
    EXPECT_FALSE(HasRetryInfo(rich));
  }
  // Who watches over the server needs none.
  EXPECT_EQ(Health(channel), "SERVING");
}

TEST_F(SecurityTest, OnlyTheRightTokenIsTaken) {
  const EventLog events;
  ServerOptions options = TlsOptions();
  options.log = events.log();
  options.token_file = files_.Write("tokens", std::string("alice ") + kToken + "\n" + kOtherToken);
  const std::unique_ptr<Server> server = StartServer(options);
  ClientSecurity security = Trusting(authority_);
  EXPECT_EQ(Call(*server, security).code(), absl::StatusCode::kUnauthenticated) << "none";
  for (const std::string& wrong :
       {std::string("0123456789abcdefABCDEG"), std::string(kToken) + "0",
        std::string(kToken).substr(0, 21), std::string(kToken) + kToken, std::string("x")}) {
    security.token_file = files_.Write("token", wrong);
    EXPECT_EQ(Call(*server, security).code(), absl::StatusCode::kUnauthenticated) << wrong;
    EXPECT_EQ(RunJob(*server, security).code(), absl::StatusCode::kUnauthenticated) << wrong;
  }
  for (const char* right : {kToken, kOtherToken}) {
    security.token_file = files_.Write("token", right);
    EXPECT_TRUE(RunJob(*server, security).ok()) << right;
  }
  EXPECT_NE(events.WaitFor("client=alice"), "");
  EXPECT_NE(events.WaitFor("client=token-2"), "");
  const std::string refused = events.WaitFor("code=UNAUTHENTICATED");
  EXPECT_NE(refused, "");
  EXPECT_EQ(refused.find(kToken), std::string::npos);
}

TEST_F(SecurityTest, TokensAreReadAgainAndBadFilesAreNot) {
  const EventLog events;
  ServerOptions options{.listen = "127.0.0.1:0", .threads = 1, .log = events.log()};
  options.token_file = files_.Write("tokens", kToken);
  const std::unique_ptr<Server> server = StartServer(options);
  const ClientSecurity old_token{.token_file = files_.Write("old", kToken)};
  const ClientSecurity new_token{.token_file = files_.Write("new", kOtherToken)};
  EXPECT_TRUE(Call(*server, old_token).ok());
  EXPECT_FALSE(Call(*server, new_token).ok());
  files_.Write("tokens", "");
  EXPECT_NE(events.WaitFor("event=tokens_not_read"), "");
  EXPECT_TRUE(Call(*server, old_token).ok()) << "after a file without tokens";
  files_.Write("tokens", kOtherToken);
  EXPECT_NE(events.WaitFor("event=tokens_read"), "");
  EXPECT_TRUE(Call(*server, new_token).ok());
  EXPECT_EQ(Call(*server, old_token).code(), absl::StatusCode::kUnauthenticated);
}

TEST_F(SecurityTest, SecretsAreEqualOnlyAsAWhole) {
  EXPECT_TRUE(SameSecret("abc", "abc"));
  EXPECT_TRUE(SameSecret("", ""));
  for (const char* given : {"", "a", "ab", "abd", "bbc", "abca", "abcabc", "abcd"}) {
    EXPECT_FALSE(SameSecret(given, "abc")) << given;
  }
  EXPECT_FALSE(SameSecret("abc", ""));
}

TEST_F(SecurityTest, AClientSendsNoTokenInTheClearToOtherMachines) {
  const ClientSecurity security{.token_file = files_.Write("token", kToken)};
  EXPECT_EQ(ReasonOf(Client::ConnectSecurely("192.0.2.1:7410", security).status()),
            Reason::kInvalidOption);
  EXPECT_TRUE(Client::ConnectSecurely("127.0.0.1:7410", security).ok());
}

TEST_F(SecurityTest, AClientNamesTheFileThatDoesNotDo) {
  const auto field = [](const ClientSecurity& security) {
    const absl::Status status = Client::ConnectSecurely("127.0.0.1:1", security).status();
    EXPECT_EQ(ReasonOf(status), Reason::kInvalidOption);
    return GetErrorDetail(status)->field;
  };
  EXPECT_EQ(field({.ca_file = files_.path("nowhere")}), "tls-ca");
  EXPECT_EQ(field({.ca_file = files_.Write("x", "no pem")}), "tls-ca");
  const TestIdentity identity = authority_.Issue("client");
  ClientSecurity security = WithIdentity(identity);
  security.key_file.clear();
  EXPECT_EQ(field(security), "tls-key");
  security = WithIdentity(identity);
  security.certificate_file = files_.path("nowhere");
  EXPECT_EQ(field(security), "tls-cert");
  EXPECT_EQ(field({.token_file = files_.path("nowhere")}), "token-file");
  EXPECT_EQ(field({.token_file = files_.Write("x", "# nothing\n")}), "token-file");
}

}  // namespace
}  // namespace limn
