// SPDX-License-Identifier: MIT
// The experiments of Zheng and Cai 2005; each writes meshes and adds its part to the report.
#pragma once

#include "tests/experiments/experiment.h"
#include "tests/experiments/report.h"

namespace limn::experiments {

// Sections 3.2 to 3.5: sweeps, time and error of the iterations, time of the perturbed first
// refined mesh, on models of the paper's sizes. Writes errors-*.tsv.
void RunSweeps(const Setup& setup, Report* report);

// Section 3.5, Figs. 4 and 5: the method against Nasri's, iterations against direct solvers. Writes
// fig4*.obj and fig5*.obj.
void RunNasri(const Setup& setup, Report* report);

// Section 4, Figs. 6 and 8: two tagged vertices with and without prescribed normals, then with
// shape handles too. Writes fig6*.obj and fig8*.obj.
void RunTagged(const Setup& setup, Report* report);

}  // namespace limn::experiments
