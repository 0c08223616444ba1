// SPDX-License-Identifier: MIT
// The table for a person says what the summary says.
#include "client/cli/report.h"

#include <gtest/gtest.h>

#include <string>

namespace limn::cli {
namespace {

v1::Summary MakeSummary() {
  v1::Summary summary;
  summary.set_input_vertices(11'540);
  summary.mutable_solve()->set_method(v1::SolveOptions::METHOD_CHEBYSHEV);
  summary.mutable_solve()->set_rule(v1::SolveOptions::RULE_MODIFIED);
  summary.mutable_solve()->set_sweeps(15);
  summary.mutable_solve()->set_converged(true);
  v1::Certificate& certificate = *summary.mutable_certificate();
  certificate.set_points_checked(5'000);
  certificate.set_max_error(2e-16);
  certificate.set_mean_error(5e-17);
  certificate.set_bounding_box_diagonal(4);
  certificate.set_max_error_vertex(77);
  return summary;
}

bool HasLine(const std::string& table, const std::string& line) {
  return ("\n" + table).find("\n" + line + "\n") != std::string::npos;
}

TEST(ReportTest, TableTellsPointsErrorsAndTheRule) {
  const std::string table = SummaryTable(MakeSummary());
  EXPECT_TRUE(HasLine(table, "points checked         5,000")) << table;
  EXPECT_TRUE(
      HasLine(table, "largest error          2.00e-16 (5.0e-17 of the bounding box) at vertex 77"))
      << table;
  EXPECT_TRUE(HasLine(table, "mean error             5.00e-17 (1.2e-17 of the bounding box)"))
      << table;
  EXPECT_TRUE(HasLine(table,
                      "sweeps                 15 (Chebyshev, modified rule, converged, "
                      "residual 0.0e+00 of the bounding box)"))
      << table;
  EXPECT_EQ(table.find("normals"), std::string::npos) << table;
}

TEST(ReportTest, TableTellsNormalsWhereSomeWerePrescribed) {
  v1::Summary summary = MakeSummary();
  summary.mutable_solve()->set_rule(v1::SolveOptions::RULE_STANDARD);
  summary.mutable_certificate()->set_normals_checked(1'200);
  summary.mutable_certificate()->set_max_normal_deviation(3.25e-11);
  summary.mutable_certificate()->set_max_normal_deviation_vertex(9);
  const std::string table = SummaryTable(summary);
  EXPECT_TRUE(HasLine(table, "normals checked        1,200")) << table;
  EXPECT_TRUE(HasLine(table, "largest deviation      3.25e-11 rad at vertex 9")) << table;
  EXPECT_NE(table.find("standard rule"), std::string::npos) << table;
}

TEST(ReportTest, TableLeavesOutWhatWasNotChecked) {
  v1::Summary summary = MakeSummary();
  summary.clear_certificate();
  const std::string table = SummaryTable(summary);
  for (const char* word : {"checked", "error", "deviation"}) {
    EXPECT_EQ(table.find(word), std::string::npos) << word << table;
  }
}

}  // namespace
}  // namespace limn::cli
