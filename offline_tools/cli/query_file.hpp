#pragma once
#include <string>
#include <vector>

#include "swiftlet/types.hpp"

namespace swiftlet::tools {

/// One row of a query file: start and goal, [m] frame W; not necessarily finite.
struct Query {
  Vector3 start;
  Vector3 goal;
};

/// Reads the columns x0,y0,z0,x1,y1,z1 of a CSV file by the names in its header; other columns are ignored, empty lines
/// skipped. Throws Failure (kBadFile) naming file and line for a missing column, a row of another width or a field that
/// is no number.
std::vector<Query> load_queries(const std::string& path);

}  // namespace swiftlet::tools
