// SPDX-License-Identifier: MIT
// A job's summary, for a person and for a program.
#include "client/cli/report.h"

#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"

namespace limn::cli {
namespace {

std::string Row(std::string_view name, const std::string& value) {
  return absl::StrFormat("%-22s %s\n", name, value);
}

std::string_view MethodName(v1::SolveOptions::Method method) {
  switch (method) {
    case v1::SolveOptions::METHOD_JACOBI:
      return "Jacobi";
    case v1::SolveOptions::METHOD_GAUSS_SEIDEL:
      return "Gauss-Seidel";
    case v1::SolveOptions::METHOD_CHEBYSHEV:
      return "Chebyshev";
    case v1::SolveOptions::METHOD_CONJUGATE_GRADIENT:
      return "conjugate gradients";
    case v1::SolveOptions::METHOD_SERIES:
      return "series";
    default:
      return "other";
  }
}

std::string RuleName(const v1::SolveReport& solve) {
  switch (solve.rule()) {
    case v1::SolveOptions::RULE_MODIFIED:
      return "modified";
    case v1::SolveOptions::RULE_STANDARD:
      return "standard";
    case v1::SolveOptions::RULE_BILINEAR_FIRST_STEP:
      return absl::StrFormat("%.0f %% bilinear", 100 * solve.bilinear_share());
    case v1::SolveOptions::RULE_FEATURE_VALUES:
      return "feature values";
    default:
      return "other";
  }
}

std::string SolveText(const v1::SolveReport& solve) {
  return absl::StrFormat("%u (%s, %s rule, %s, residual %.1e of the bounding box)", solve.sweeps(),
                         MethodName(solve.method()), RuleName(solve),
                         solve.converged() ? "converged" : "tolerance not met", solve.residual());
}

std::string LengthText(double length, const v1::Certificate& certificate) {
  const double diagonal = certificate.bounding_box_diagonal();
  return absl::StrFormat("%.2e (%.1e of the bounding box)", length,
                         diagonal > 0 ? length / diagonal : 0.0);
}

std::string CertificateRows(const v1::Certificate& certificate) {
  std::string rows;
  if (certificate.points_checked() > 0) {
    rows += Row("points checked", WithCommas(certificate.points_checked()));
    rows +=
        Row("largest error", LengthText(certificate.max_error(), certificate) +
                                 absl::StrFormat(" at vertex %u", certificate.max_error_vertex()));
    rows += Row("mean error", LengthText(certificate.mean_error(), certificate));
  }
  if (certificate.normals_checked() > 0) {
    rows += Row("normals checked", WithCommas(certificate.normals_checked()));
    rows += Row("largest deviation",
                absl::StrFormat("%.2e rad at vertex %u", certificate.max_normal_deviation(),
                                certificate.max_normal_deviation_vertex()));
  }
  return rows;
}

// A row for each kind of change.
std::string FairnessRow(const v1::FairnessReport& fairness) {
  const bool both = fairness.shape_handles() && fairness.smoothing();
  const std::string cures = both                       ? "handles and smoothing"
                            : fairness.shape_handles() ? "handles"
                            : fairness.smoothing()     ? "smoothing"
                                                       : "nothing lowers it";
  return Row("bending energy", absl::StrFormat("%.6g, before %.6g (%s)", fairness.energy_after(),
                                               fairness.energy_before(), cures));
}

std::string BlendRows(const v1::BlendReport& blend) {
  std::string rows = Row("met on the surface", WithCommas(blend.constraints()) + " constraints");
  if (blend.together() > 0) rows += Row("", WithCommas(blend.together()) + " of them together");
  return rows + Row("control points moved", WithCommas(blend.moved_points()) + " of level 2");
}

std::string RepairRows(const v1::RepairReport& repair) {
  const std::pair<std::uint64_t, std::string_view> changes[] = {
      {repair.degenerate_faces_removed(), "degenerate faces removed"},
      {repair.faces_mended(), "faces cut where they visited a vertex again"},
      {repair.repeated_faces_removed(), "repeated faces removed"},
      {repair.folded_faces_removed(), "folded faces removed"},
      {repair.faces_reoriented(), "faces turned round"},
      {repair.edges_cut(), "edges cut that no orientation suits"},
      {repair.edges_split(), "edges of more than two faces taken apart"},
      {repair.faces_split_off(), "faces split off"},
      {repair.vertices_split(), "vertices split"},
      {repair.vertices_added(), "vertices added by that"},
      {repair.isolated_vertices_removed(), "isolated vertices removed"},
  };
  std::string rows;
  for (const auto& [count, what] : changes) {
    if (count == 0) continue;
    rows += Row(rows.empty() ? "repaired" : "",
                std::string(what).append(": ").append(WithCommas(count)));
  }
  return rows.empty() ? Row("repaired", "nothing: there was no need") : rows;
}

}  // namespace

std::string WithCommas(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, 1, ',');
  return digits;
}

std::string SummaryTable(const v1::Summary& summary) {
  std::string table;
  table += Row("given vertices", WithCommas(summary.input_vertices()));
  table += Row("given faces", WithCommas(summary.input_faces()));
  if (summary.has_fairness()) table += FairnessRow(summary.fairness());
  if (summary.has_blend()) table += BlendRows(summary.blend());
  if (summary.has_repair()) table += RepairRows(summary.repair());
  if (summary.surface_vertices() > 0) {
    table += Row("surface vertices", WithCommas(summary.surface_vertices()));
    table += Row("surface faces", WithCommas(summary.surface_faces()) +
                                      absl::StrFormat(" (level %u)", summary.level()));
    if (summary.has_chord_bound()) {
      table += Row("from the surface", absl::StrFormat("at most %.3g", summary.chord_bound()));
    }
  }
  if (summary.solve().rule() == v1::SolveOptions::RULE_FEATURE_VALUES) {
    table += Row("first refinement", "by feature values, of the given mesh");
  } else {
    table += Row("sweeps", SolveText(summary.solve()));
  }
  table += CertificateRows(summary.certificate());
  for (const v1::StageTime& stage : summary.stages()) {
    table += Row("  " + stage.stage(), absl::StrFormat("%10.3f ms", stage.milliseconds()));
  }
  table += Row("bytes to the server", WithCommas(summary.bytes_received()));
  table += Row("bytes from the server", WithCommas(summary.bytes_sent()));
  return table;
}

}  // namespace limn::cli
