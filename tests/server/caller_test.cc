// SPDX-License-Identifier: MIT
// A call's name and trace go through the server: back to the client, into errors, into the log.
#include "server/caller.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "tests/server/service_fixture.h"

namespace limn {
namespace {

constexpr char kTraceId[] = "0af7651916cd43dd8448eb211c80319c";
constexpr char kParentId[] = "b7ad6b7169203331";

std::string TraceParentText() { return std::string("00-") + kTraceId + "-" + kParentId + "-01"; }

// One call with metadata, to its end.
struct NamedCall {
  NamedCall(const std::shared_ptr<grpc::Channel>& channel,
            const std::vector<v1::InterpolateRequest>& upload,
            const std::map<std::string, std::string>& metadata) {
    for (const auto& [name, value] : metadata) context.AddMetadata(name, value);
    const auto stub = v1::LimnService::NewStub(channel);
    const auto stream = stub->Interpolate(&context);
    for (const v1::InterpolateRequest& request : upload) stream->Write(request);
    stream->WritesDone();
    v1::InterpolateResponse response;
    while (stream->Read(&response)) {
      if (response.has_accepted()) accepted = response.accepted().request_id();
    }
    status = stream->Finish();
  }
  static std::string Value(const std::multimap<grpc::string_ref, grpc::string_ref>& metadata) {
    const auto found = metadata.find(kRequestIdKey);
    return found == metadata.end() ? "" : std::string(found->second.data(), found->second.size());
  }
  std::string initial() const { return Value(context.GetServerInitialMetadata()); }
  std::string trailing() const { return Value(context.GetServerTrailingMetadata()); }

  grpc::ClientContext context;
  grpc::Status status;
  std::string accepted;
};

class CallerTest : public testing::Test {
 protected:
  CallerTest() {
    options_.log = events_.log();
    server_ = StartServer(options_);
  }
  const EventLog events_;
  ServerOptions options_{.listen = "127.0.0.1:0", .threads = 1};
  std::unique_ptr<Server> server_;
  const std::vector<v1::InterpolateRequest> upload_ = MakeUpload(MakeHeader(0), MakeSphere(32));
};

TEST_F(CallerTest, TheClientsNameAndTraceReachAnswerAndLog) {
  const NamedCall call(server_->InProcessChannel(), upload_,
                       {{kRequestIdKey, "job-17"}, {"traceparent", TraceParentText()}});
  ASSERT_TRUE(call.status.ok()) << call.status.error_message();
  EXPECT_EQ(call.accepted, "job-17");
  EXPECT_EQ(call.initial(), "job-17");
  EXPECT_EQ(call.trailing(), "job-17");
  const std::string line = events_.WaitFor("request_id=job-17");
  EXPECT_NE(line.find(std::string("trace_id=") + kTraceId), std::string::npos) << line;
  EXPECT_NE(line.find(std::string("parent_id=") + kParentId), std::string::npos) << line;
}

TEST_F(CallerTest, TheHeadersNameComesFirst) {
  std::vector<v1::InterpolateRequest> upload = upload_;
  upload[0].mutable_header()->set_request_id("of-the-header");
  const NamedCall call(server_->InProcessChannel(), upload, {{kRequestIdKey, "of-the-call"}});
  EXPECT_EQ(call.accepted, "of-the-header");
  EXPECT_EQ(call.trailing(), "of-the-header");
}

TEST_F(CallerTest, ANameIsMadeWhereNoneOrNoGoodOneComes) {
  const NamedCall without(server_->InProcessChannel(), upload_, {});
  EXPECT_EQ(without.accepted.size(), 16U);
  EXPECT_EQ(without.trailing(), without.accepted);
  const NamedCall blank(server_->InProcessChannel(), upload_, {{kRequestIdKey, "two words"}});
  EXPECT_EQ(blank.accepted.size(), 16U);
  EXPECT_NE(blank.accepted, without.accepted);
  const NamedCall large(server_->InProcessChannel(), upload_,
                        {{kRequestIdKey, std::string(129, 'x')}});
  EXPECT_EQ(large.accepted.size(), 16U);
}

TEST_F(CallerTest, ErrorsCarryTheName) {
  const NamedCall call(server_->InProcessChannel(), {upload_.back()}, {{kRequestIdKey, "job-18"}});
  EXPECT_EQ(call.status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(call.trailing(), "job-18");
  v1::RichStatus rich;
  ASSERT_TRUE(rich.ParseFromString(call.status.error_details()));
  EXPECT_EQ(ErrorInfoOf(rich).metadata().at("request_id"), "job-18");
}

TEST_F(CallerTest, BrokenTracesAreLeftOut) {
  const NamedCall call(server_->InProcessChannel(), upload_,
                       {{kRequestIdKey, "job-19"}, {"traceparent", "00-xyz-1-01"}});
  const std::string line = events_.WaitFor("request_id=job-19");
  EXPECT_NE(line, "");
  EXPECT_EQ(line.find("trace_id"), std::string::npos) << line;
}

TEST(TraceParentTest, IsReadAsTheStandardSays) {
  EXPECT_EQ(ParseTraceParent(TraceParentText()).trace_id, kTraceId);
  EXPECT_EQ(ParseTraceParent(TraceParentText()).parent_id, kParentId);
  // Later versions may have more behind it, version 00 may not.
  const std::string later = "cc" + TraceParentText().substr(2) + "-more";
  EXPECT_EQ(ParseTraceParent(later).trace_id, kTraceId);
  const std::string zeros(32, '0');
  for (const std::string& bad :
       {std::string(), TraceParentText() + "-more", TraceParentText().substr(0, 54),
        "ff" + TraceParentText().substr(2), "0x" + TraceParentText().substr(2),
        "00-" + zeros + "-" + kParentId + "-01",
        std::string("00-") + kTraceId + "-0000000000000000-01",
        std::string("00-") + kTraceId + "_" + kParentId + "-01",
        std::string("00-0AF7651916CD43DD8448EB211C80319C-") + kParentId + "-01",
        std::string("cc") + TraceParentText().substr(2) + "more"}) {
    EXPECT_EQ(ParseTraceParent(bad).trace_id, "") << bad;
    EXPECT_EQ(ParseTraceParent(bad).parent_id, "") << bad;
  }
}

}  // namespace
}  // namespace limn
