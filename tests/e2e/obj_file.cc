// SPDX-License-Identifier: MIT
// A plain reader of OBJ files, written without the product's own.
#include "tests/e2e/obj_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace limn::e2e {
namespace {

std::array<double, 3> ReadTriple(std::istringstream& words, std::vector<std::string>* texts) {
  std::array<double, 3> triple;
  for (double& value : triple) {
    std::string word;
    if (!(words >> word)) throw std::runtime_error("three numbers were expected");
    char* end = nullptr;
    value = std::strtod(word.c_str(), &end);
    if (*end != 0) throw std::runtime_error("not a number: " + word);
    if (texts != nullptr) texts->push_back(word);
  }
  return triple;
}

std::vector<long> ReadFace(std::istringstream& words) {
  std::vector<long> face;
  std::string word;
  // Of "v", "v/t", "v//n" and "v/t/n" only v matters here.
  while (words >> word) face.push_back(std::strtol(word.c_str(), nullptr, 10) - 1);
  return face;
}

}  // namespace

ObjFile ReadObj(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot open " + path.string());
  ObjFile mesh;
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "v") {
      mesh.positions.push_back(ReadTriple(words, &mesh.coordinates));
    } else if (key == "vn") {
      mesh.normals.push_back(ReadTriple(words, nullptr));
    } else if (key == "f") {
      mesh.faces.push_back(ReadFace(words));
    } else if (!key.empty() && key[0] != '#' && key != "o" && key != "g" && key != "s") {
      throw std::runtime_error("unknown line: " + line);
    }
  }
  return mesh;
}

double Diagonal(const ObjFile& mesh) {
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (const auto& point : mesh.positions) {
      low = std::min(low, point[axis]);
      high = std::max(high, point[axis]);
    }
    sum += (high - low) * (high - low);
  }
  return std::sqrt(sum);
}

double LargestDistance(const ObjFile& given, const ObjFile& surface) {
  if (surface.positions.size() < given.positions.size()) {
    return std::numeric_limits<double>::infinity();
  }
  double largest = 0;
  for (std::size_t i = 0; i < given.positions.size(); ++i) {
    const auto& a = given.positions[i];
    const auto& b = surface.positions[i];
    largest = std::max(largest, std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]));
  }
  return largest;
}

}  // namespace limn::e2e
