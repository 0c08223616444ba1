// SPDX-License-Identifier: MIT
// `limn info`: what a mesh file holds, and what is wrong with it.
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "absl/strings/str_format.h"
#include "client/cli/commands.h"
#include "client/cli/json_object.h"
#include "client/cli/report.h"
#include "client/io/mesh_reader.h"
#include "engine/mesh/mesh_info.h"
#include "engine/mesh/repair.h"

namespace limn::cli {
namespace {

using Histogram = std::map<std::uint64_t, std::uint64_t>;

struct InfoFlags {
  std::string input;
  bool json = false;
};

std::string Row(const char* name, const std::string& value) {
  return absl::StrFormat("%-18s %s\n", name, value);
}

std::string Triple(const Vec3& v) { return absl::StrFormat("(%.9g, %.9g, %.9g)", v.x, v.y, v.z); }

// "1 loop", "2 loops".
std::string Counted(std::uint64_t count, const char* what) {
  return absl::StrFormat("%s %s%s", WithCommas(count), what, count == 1 ? "" : "s");
}

// "3-8 (3: 120, 4: 90, ...)".
std::string HistogramText(const Histogram& histogram) {
  if (histogram.empty()) return "-";
  constexpr std::size_t kShown = 12;
  std::string text =
      absl::StrFormat("%u-%u (", histogram.begin()->first, histogram.rbegin()->first);
  std::size_t shown = 0;
  for (const auto& [key, count] : histogram) {
    if (shown == kShown) {
      text += ", ...";
      break;
    }
    text += absl::StrFormat("%s%u: %s", shown++ == 0 ? "" : ", ", key, WithCommas(count));
  }
  return text + ")";
}

std::string InfoText(const MeshInfo& info) {
  std::string text;
  text += Row("vertices", WithCommas(info.vertices));
  text += Row("faces", WithCommas(info.faces));
  text += Row("edges", WithCommas(info.edges));
  text += Row("corners", WithCommas(info.corners));
  text += Row("sides of faces", HistogramText(info.arities));
  text += Row("valences", HistogramText(info.valences));
  text += Row("boundary", info.closed() ? "none: closed"
                                        : Counted(info.boundary_loops, "loop") + " of " +
                                              Counted(info.boundary_edges, "edge"));
  text += Row("components", WithCommas(info.components));
  text += Row("genus", info.genus ? std::to_string(*info.genus) : "-");
  text += Row("Euler", std::to_string(info.euler_characteristic));
  text += Row("bounding box", Triple(info.box.min) + " to " + Triple(info.box.max));
  if (info.problems.empty()) text += Row("problems", "none");
  for (const MeshProblem& problem : info.problems) {
    text +=
        Row("problem", problem.text + (RepairMends(problem.reason) ? "; --repair mends that" : ""));
  }
  return text;
}

JsonObject HistogramJson(const Histogram& histogram) {
  JsonObject object;
  for (const auto& [key, count] : histogram) object.Add(std::to_string(key), count);
  return object;
}

std::string InfoJson(const MeshInfo& info) {
  JsonObject object;
  object.Add("vertices", info.vertices).Add("faces", info.faces).Add("edges", info.edges);
  object.Add("corners", info.corners);
  object.Add("arities", HistogramJson(info.arities));
  object.Add("valences", HistogramJson(info.valences));
  object.Add("closed", info.closed());
  object.Add("boundaryEdges", info.boundary_edges).Add("boundaryLoops", info.boundary_loops);
  object.Add("components", info.components);
  object.Add("eulerCharacteristic", info.euler_characteristic);
  if (info.genus) object.Add("genus", *info.genus);
  object.Add("boxMin", {info.box.min.x, info.box.min.y, info.box.min.z});
  object.Add("boxMax", {info.box.max.x, info.box.max.y, info.box.max.z});
  std::vector<JsonObject> problems;
  for (const MeshProblem& problem : info.problems) {
    JsonObject& entry = problems.emplace_back();
    entry.Add("reason", ReasonName(problem.reason)).Add("count", problem.count);
    entry.Add("first", problem.first).Add("text", std::string_view(problem.text));
    entry.Add("repairable", RepairMends(problem.reason));
  }
  object.Add("problems", problems);
  return object.Text() + "\n";
}

ExitStatus Run(const InfoFlags& flags) {
  const absl::StatusOr<PolygonMesh> mesh = ReadMeshFile(flags.input);
  if (!mesh.ok()) return FailWithFile(mesh.status());
  const MeshInfo info = DescribeMesh(*mesh);
  std::fputs((flags.json ? InfoJson(info) : InfoText(info)).c_str(), stdout);
  return ExitStatus::kOk;
}

}  // namespace

void AddInfoCommand(CLI::App& app, ExitStatus* status) {
  CLI::App* command = app.add_subcommand("info", "Tell what a mesh is and what is wrong with it");
  const auto flags = std::make_shared<InfoFlags>();
  command->add_option("FILE", flags->input, "Mesh: .obj, .off, .ply or .stl")->required();
  command->add_flag("--json", flags->json, "As JSON");
  command->footer("Exit status 0 also for a mesh with problems, as long as the file can be read.");
  command->callback([flags, status] { *status = Run(*flags); });
}

}  // namespace limn::cli
