// SPDX-License-Identifier: MIT
// A plain reader of OBJ files, written without the product's own.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

namespace limn::e2e {

struct ObjFile {
  std::vector<std::array<double, 3>> positions;
  std::vector<std::array<double, 3>> normals;
  // Vertex numbers from 0.
  std::vector<std::vector<long>> faces;
  // The texts of the coordinates, as they stand in the file.
  std::vector<std::string> coordinates;
};

// Throws std::runtime_error for a line that is not understood.
ObjFile ReadObj(const std::filesystem::path& path);

// Length of the bounding box's diagonal.
double Diagonal(const ObjFile& mesh);

// Largest distance between the first vertices of `surface` and those of `given`, in the order of
// the files; infinite when the surface has fewer.
double LargestDistance(const ObjFile& given, const ObjFile& surface);

}  // namespace limn::e2e
