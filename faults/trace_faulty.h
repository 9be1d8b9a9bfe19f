// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "renderer/trace.h"

namespace plumb {

// trace() with the fault of the job's settings.
int64_t trace_faulty(const TraceJob<PackedScene<float>>& job);

}  // namespace plumb
