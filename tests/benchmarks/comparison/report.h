// SPDX-License-Identifier: MIT
// A report's three forms.
#pragma once

#include <string>

#include "tests/benchmarks/comparison/goals.h"

namespace limn::comparison {

// Tables.
std::string Markdown(const Report& report);

// All figures: {"cells": [...], "bandwidth": [...], "kernels": [...], "jobs": [...], "goals":
// [...]}, times in seconds, memory in bytes.
std::string Json(const Report& report);

// For each task a file ratios-TASK.tsv in the folder: vertices, and how many times as long as Limn
// with one thread each contestant takes on polygons (Loop: on triangles).
void WriteRatios(const Report& report, const std::string& folder);

}  // namespace limn::comparison
